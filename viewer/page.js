// The page's own script: it asks the server through a hidden text control, whose values are numbered because viser
// drops one that is equal to the last; keeps the address; and shows the values under the cursor.
//
// Private to viser: window.__viserMutable.{sendMessage, canvas, camera, nodeRefFromName}, __viserTestpoints.uplots.
const taichiflap = (() => {
  const find = (name) => document.getElementById(name);
  const told = (name) => { const element = find(name); return element ? element.dataset.is : null; };
  const tip = document.createElement("div");
  let asked = 0, address = null, opened = null, written = {}, moved = false, over = null, cursor = null, sent = 0, answer = null;
  tip.id = "tf-tip";

  function send(what, value) {
    const page = window.__viserMutable, to = told("tf-to");
    if (!page || !to) return;
    const words = JSON.stringify([++asked, what, value === undefined ? null : value]);
    page.sendMessage({type: "GuiUpdateMessage", uuid: JSON.parse(to), updates: {value: words}});
  }

  function show(text, x, y) {
    tip.style.display = text ? "block" : "none";
    if (!text) return;
    tip.textContent = text;
    tip.style.left = `${Math.min(x + 12, innerWidth - tip.offsetWidth - 4)}px`;
    tip.style.top = `${Math.min(y + 12, innerHeight - tip.offsetHeight - 4)}px`;
  }

  // The scene is flat: its x to the right, its z up, seen along its y.
  function eye() {
    const {camera, nodeRefFromName} = window.__viserMutable;
    return nodeRefFromName[""].worldToLocal(camera.position.clone());
  }
  function scenePlace(x, y) {
    const {canvas, camera} = window.__viserMutable, box = canvas.getBoundingClientRect(), from = eye();
    const half = -from.y * Math.tan(camera.fov * Math.PI / 360), wide = half * box.width / box.height;
    return [from.x + wide * (2 * (x - box.left) / box.width - 1), from.z + half * (1 - 2 * (y - box.top) / box.height)];
  }

  // What the address holds: what the server says, and the view, once somebody has panned or zoomed.
  function view() {
    const from = eye();
    return [from.x, from.z, -from.y].map((one) => +one.toFixed(3));
  }
  function remember() {
    const held = told("tf-address"), page = window.__viserMutable;
    if (!held || !page || !page.camera || !page.nodeRefFromName[""]) return;
    // A page that is built anew, of the case of a map for instance, has an address of its own.
    if (opened === null) {
      opened = performance.now();
      const known = Object.keys(JSON.parse(held)), given = new URLSearchParams(location.search);
      const chosen = Object.fromEntries(known.filter((name) => given.has(name)).map((name) => [name, given.get(name)]));
      if (Object.keys(chosen).length) send("address", chosen);
      const seen = (given.get("view") || "").split(",").map(Number);
      if (seen.length === 3 && seen.every(Number.isFinite)) { moved = true; send("view", seen); }
    }
    const now = held + (moved ? view() : "");
    if (now === address || performance.now() - opened < 1500) return;
    address = now;
    const to = new URL(location.href), wanted = {...written, ...JSON.parse(held), view: moved ? view().join() : null};
    // What another page, of the same window, has held before goes.
    written = Object.fromEntries(Object.keys(wanted).map((name) => [name, null]));
    for (const [name, value] of Object.entries(wanted)) {
      if (value === null) to.searchParams.delete(name); else to.searchParams.set(name, value);
    }
    // Names of keys and commas can be read as they are.
    to.search = to.search.replace(/%2C/g, ",").replace(/%3A/g, ":");
    if (to.href !== location.href) history.replaceState(null, "", to.href);
  }
  setInterval(remember, 300);

  const chartUnder = (event) => {
    const inside = event.target.closest && event.target.closest(".u-over");
    const all = Object.values((window.__viserTestpoints || {}).uplots || {});
    return inside ? [all.map((one) => one.chart).find((one) => one.over === inside), inside] : [];
  };
  // The values of a chart's curves; each is followed by as many that are dots.
  function chartText(chart, inside, x) {
    const at = chart.posToVal(x - inside.getBoundingClientRect().left, "x"), places = chart.data[0];
    let nearest = 0;
    places.forEach((one, i) => { if (Math.abs(one - at) < Math.abs(places[nearest] - at)) nearest = i; });
    const lines = chart.series.slice(1).map((one, i) => [one, chart.data[i + 1][nearest]]);
    const curves = lines.filter(([one]) => !(one.points && one.points.size > 5));
    const name = chart.series[0].label || "";
    return [`${name} = ${Number(places[nearest]).toPrecision(4)}`,
      ...curves.map(([one, value]) => `${one.label ? one.label + ": " : ""}${
        value === null || Number.isNaN(value) ? "–" : Number(value).toPrecision(4)}`)].join("\n");
  }

  addEventListener("pointermove", (event) => {
    const [chart, inside] = chartUnder(event), page = window.__viserMutable;
    over = null;
    if (chart) { show(chartText(chart, inside, event.clientX), event.clientX, event.clientY); return; }
    if (!page || event.target !== page.canvas || event.buttons) { show("", 0, 0); cursor = null; return; }
    over = [event.clientX, event.clientY];
    cursor = scenePlace(...over);
    show(JSON.parse(told("tf-cursor") || '""'), ...over);
  }, true);
  for (const kind of ["wheel", "pointermove"]) {
    addEventListener(kind, (event) => {
      const page = window.__viserMutable;
      if (page && event.target === page.canvas && (kind === "wheel" || event.buttons)) moved = true;
    }, {capture: true, passive: true});
  }
  addEventListener("click", (event) => {
    const near = (names) => event.target.closest && event.target.closest(names);
    if (near("button") && near("button").textContent.trim() === "Reset view") moved = false;
    const text = near("[data-copy]");
    if (text && navigator.clipboard) navigator.clipboard.writeText(text.textContent);
  }, true);

  // A double click in the scene releases fluid there.
  addEventListener("dblclick", (event) => {
    const page = window.__viserMutable;
    if (page && event.target === page.canvas) send("release", scenePlace(event.clientX, event.clientY));
  }, true);

  function look() {
    requestAnimationFrame(look);
    if (cursor && performance.now() - sent > 60) { send("cursor", cursor); sent = performance.now(); cursor = null; }
    const now = told("tf-cursor");
    if (now === answer) return;
    answer = now;
    if (over) show(now ? JSON.parse(now) : "", ...over);
  }
  addEventListener("DOMContentLoaded", () => { document.body.append(tip); look(); });
  // What the canvas shows of the scene: left, top and right.
  function seen() {
    const box = window.__viserMutable.canvas.getBoundingClientRect();
    const [left, top] = scenePlace(box.left, box.top);
    return [left, top, scenePlace(box.right, box.top)[0]];
  }
  return {send, find, told, chartUnder, seen};
})();
