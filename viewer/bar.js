// The timeline along the foot of the page. The server tells it by two hidden elements of the panel, what a run is
// (#tf-run) and where it stands (#tf-state); the page asks through a hidden text control, whose values are numbered
// because viser drops one that is equal to the last.
//
// Private to viser: window.__viserMutable.sendMessage, window.__viserTestpoints.uplots, #root.
(() => {
  const EDGE = 12, BLUE = "#1c7ed6", RED = "#c81e2d";
  const NOT_WHILE_TYPING = "input,textarea,select,[contenteditable],[role=dialog],[role=listbox]";
  const bar = document.createElement("div"), tip = document.createElement("div");
  const find = (name) => document.getElementById(name);
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  let run = null, state = null, told = "", asked = 0, local = null, pending = null, sent = 0, drag = null, opened = false;

  bar.id = "tf-bar";
  tip.id = "tf-tip";
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", "Timeline");
  bar.innerHTML = `<output id="tf-time"></output>
    <div id="tf-buttons"><button id="tf-previous" title="previous stroke reversal">previous</button>
    <button id="tf-play" aria-label="Play"></button>
    <button id="tf-next" title="next stroke reversal">next</button></div>
    <canvas id="tf-line" role="slider" tabindex="0" aria-label="Timeline" aria-valuemin="0"></canvas>
    <div id="tf-choices"><input id="tf-frame" type="number" min="0" step="1" aria-label="Frame">
    <select id="tf-loop" aria-label="Loop"></select><select id="tf-speed" aria-label="Speed"></select></div>`;

  function send(what, value) {
    const page = window.__viserMutable;
    if (!run || !page) return;
    const words = JSON.stringify([++asked, what, value === undefined ? null : value]);
    page.sendMessage({type: "GuiUpdateMessage", uuid: run.to, updates: {value: words}});
  }

  // A drag asks for a frame no more often than the page looks; the cursor goes ahead of the answer.
  function seek(frame) {
    local = pending = clamp(Math.round(frame), 0, run.frames - 1);
  }

  const width = () => find("tf-line").clientWidth - 2 * EDGE;
  const placeOf = (frame) => EDGE + width() * frame / Math.max(run.frames - 1, 1);
  const frameAt = (place) => clamp((place - EDGE) / width(), 0, 1) * (run.frames - 1);

  function draw() {
    const canvas = find("tf-line"), dense = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
    if (canvas.width !== Math.round(w * dense)) canvas.width = Math.round(w * dense);
    if (canvas.height !== Math.round(h * dense)) canvas.height = Math.round(h * dense);
    const pen = canvas.getContext("2d"), dark = state.dark, top = 6, foot = h - 14;
    const [first, last] = drag && drag.range ? drag.range : state.loop;
    const line = (x, low, high) => { pen.moveTo(x, low); pen.lineTo(x, high); };
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.clearRect(0, 0, w, h);
    pen.font = "11px sans-serif";
    pen.textBaseline = "bottom";
    pen.textAlign = "center";
    pen.fillStyle = dark ? "#2a3442" : "#e3eefb";
    pen.fillRect(placeOf(first), top, placeOf(last) - placeOf(first), foot - top);
    pen.strokeStyle = dark ? "#42464d" : "#ccd3db";
    pen.fillStyle = dark ? "#c5cad2" : "#4b5563";
    pen.lineWidth = 1;
    pen.beginPath();
    const beats = (run.frames - 1) / run.perBeat, every = [1, 2, 5, 10, 20, 50, 100, 1000].find(
      (n) => n * width() / beats > 22) || 10000;
    for (let k = 0; k <= beats + 1e-9; k++) {
      if (width() / beats > 3 || k % every === 0) line(placeOf(k * run.perBeat), top, foot + 3);
      if (run.periodic && k % every === 0) pen.fillText(k, placeOf(k * run.perBeat), h);
    }
    pen.stroke();
    pen.beginPath();
    run.reversals.forEach((frame) => line(placeOf(frame), foot - 4, foot));
    pen.strokeStyle = dark ? "#8a919c" : "#8b95a1";
    pen.stroke();
    pen.strokeStyle = dark ? "#6ab0ff" : BLUE;
    pen.lineWidth = 1.2;
    pen.beginPath();
    run.curve.forEach((value, i) => {
      const x = EDGE + width() * i / Math.max(run.curve.length - 1, 1), y = foot - 3 - value * (foot - top - 6);
      if (i) pen.lineTo(x, y); else pen.moveTo(x, y);
    });
    pen.stroke();
    pen.fillStyle = dark ? "#6ab0ff" : BLUE;
    for (const edge of [first, last]) pen.fillRect(placeOf(edge) - 2, top, 4, foot - top);
    const now = placeOf(local === null ? state.frame : local);
    pen.strokeStyle = pen.fillStyle = RED;
    pen.lineWidth = 2;
    pen.beginPath();
    line(now, 0, foot + 4);
    pen.stroke();
    pen.beginPath();
    pen.arc(now, 5, 5, 0, 7);
    pen.fill();
  }

  function show() {
    const play = find("tf-play"), slider = find("tf-line"), frame = find("tf-frame");
    document.body.classList.toggle("tf-dark", state.dark);
    play.textContent = state.playing ? "❚❚" : "▶\ufe0e";
    play.setAttribute("aria-label", state.playing ? "Pause" : "Play");
    find("tf-time").textContent = state.text;
    slider.setAttribute("aria-valuemax", run.frames - 1);
    slider.setAttribute("aria-valuenow", state.frame);
    slider.setAttribute("aria-valuetext", state.text);
    frame.max = run.frames - 1;
    if (document.activeElement !== frame) frame.value = state.frame;
    for (const name of ["speed", "loop"]) {
      const menu = find(`tf-${name}`), names = run[name === "speed" ? "speeds" : "loops"];
      if (menu.length !== names.length) menu.replaceChildren(...names.map((one) => new Option(one, one)));
      menu.value = state[name === "speed" ? "speed" : "loopName"];
    }
    for (const name of ["previous", "next"]) find(`tf-${name}`).disabled = !run.reversals.length;
    draw();
    remember();
  }

  // The address says where the page stands: ?frame=120 opens there, for a colleague as well.
  function remember() {
    if (!opened) {
      opened = true;
      const frame = new URLSearchParams(location.search).get("frame");
      if (frame !== null && Number.isFinite(+frame)) seek(+frame);
    } else if (!state.playing && local === null) {
      const address = new URL(location.href);
      if (address.searchParams.get("frame") === String(state.frame)) return;
      address.searchParams.set("frame", state.frame);
      clearTimeout(remember.later);
      remember.later = setTimeout(() => history.replaceState(null, "", address.href), 300);
    }
  }

  function look() {
    requestAnimationFrame(look);
    const what = find("tf-run"), where = find("tf-state");
    const there = Boolean(what && where);
    if (there !== document.body.classList.contains("tf-on")) document.body.classList.toggle("tf-on", there);
    if (!there) { run = state = null; return; }
    if (!run || run.raw !== what.dataset.is) { run = {...JSON.parse(what.dataset.is), raw: what.dataset.is}; told = ""; }
    if (pending !== null && performance.now() - sent > 15) { send("frame", pending); sent = performance.now(); pending = null; }
    const size = `${innerWidth} ${innerHeight}`;
    if (where.dataset.is + size === told && local === null) return;
    state = JSON.parse(where.dataset.is);
    told = where.dataset.is + size;
    if (local !== null && pending === null && !drag && (state.frame === local || performance.now() - sent > 2000)) local = null;
    show();
  }

  const KEYS = {
    " ": () => send("play"), "Home": () => send("edge", 0), "End": () => send("edge", 1),
    "ArrowLeft": (event) => send("skip", event.shiftKey ? -10 : -1),
    "ArrowRight": (event) => send("skip", event.shiftKey ? 10 : 1),
  };
  addEventListener("keydown", (event) => {
    const at = event.target, inside = (names) => at.closest && at.closest(names);
    if (!run || event.ctrlKey || event.altKey || event.metaKey || !(event.key in KEYS)) return;
    if (inside(NOT_WHILE_TYPING)) return;
    if (inside("[role=slider]:not(#tf-line)") && event.key !== " ") return;
    if (event.key === " " && inside("button:not(#tf-play),a,[role=tab],[role=checkbox]")) return;
    event.preventDefault();
    event.stopPropagation();
    KEYS[event.key](event);
  }, true);

  const chartUnder = (event) => {
    const over = event.target.closest && event.target.closest(".u-over");
    const all = Object.values((window.__viserTestpoints || {}).uplots || {});
    return over && run ? [all.map((one) => one.chart).find((one) => one.over === over), over] : [];
  };
  addEventListener("click", (event) => {
    const [chart, over] = chartUnder(event);
    if (chart) send("beats", chart.posToVal(event.clientX - over.getBoundingClientRect().left, "x"));
  }, true);
  // The values of the curves under the cursor.
  addEventListener("pointermove", (event) => {
    const [chart, over] = chartUnder(event);
    tip.style.display = chart ? "block" : "none";
    if (!chart) return;
    const time = chart.posToVal(event.clientX - over.getBoundingClientRect().left, "x"), times = chart.data[0];
    let nearest = 0;
    times.forEach((one, i) => { if (Math.abs(one - time) < Math.abs(times[nearest] - time)) nearest = i; });
    const half = (chart.data.length - 1) / 2;
    const values = chart.data.slice(1, 1 + half).map((curve) => Number(curve[nearest]).toPrecision(4));
    tip.textContent = `t/T = ${times[nearest].toFixed(3)}\n${values.join("\n")}`;
    tip.style.left = `${Math.min(event.clientX + 12, innerWidth - 110)}px`;
    tip.style.top = `${Math.min(event.clientY + 12, innerHeight - 60)}px`;
  }, true);

  addEventListener("click", (event) => {
    const text = event.target.closest && event.target.closest("[data-copy]");
    if (text && navigator.clipboard) navigator.clipboard.writeText(text.textContent);
  });

  addEventListener("DOMContentLoaded", () => {
    document.body.append(bar, tip);
    const line = find("tf-line");
    find("tf-play").onclick = () => send("play");
    find("tf-previous").onclick = () => send("reversal", -1);
    find("tf-next").onclick = () => send("reversal", 1);
    for (const name of ["speed", "loop"]) {
      find(`tf-${name}`).onchange = (event) => { send(name, event.target.value); event.target.blur(); };
    }
    find("tf-frame").onchange = (event) => { if (run) seek(+event.target.value || 0); };
    // Shift and a drag choose the range of the loop, as does a drag of either of its ends.
    line.onpointerdown = (event) => {
      if (!run || !state) return;
      line.setPointerCapture(event.pointerId);
      const x = event.offsetX, end = state.loop.findIndex((frame) => Math.abs(placeOf(frame) - x) < 5);
      drag = {};
      if (event.shiftKey) drag = {from: frameAt(x), range: [frameAt(x), frameAt(x)]};
      else if (end >= 0 && Math.abs(placeOf(state.frame) - x) > 6) drag = {from: state.loop[1 - end], range: [...state.loop]};
      else seek(frameAt(x));
    };
    line.onpointermove = (event) => {
      if (!drag || !run) return;
      const frame = frameAt(event.offsetX);
      if (!drag.range) { seek(frame); return; }
      drag.range = [Math.min(drag.from, frame), Math.max(drag.from, frame)].map(Math.round);
      draw();
    };
    line.onpointerup = line.onpointercancel = () => {
      if (drag && drag.range && run) send("range", drag.range);
      drag = null;
    };
    look();
  });
})();
