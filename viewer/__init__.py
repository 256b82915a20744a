"""The browser viewer of taichiflap's results. Reads them through `taichiflap.results`; the solver never imports it."""
