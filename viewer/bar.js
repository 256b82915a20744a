// The timeline along the foot of the page. The server tells it by two hidden elements of the panel, what a run is
// (#tf-run) and where it stands (#tf-state).
//
// Private to viser: #root.
(() => {
  const {send, find, told, chartUnder} = taichiflap;
  const bar = document.createElement("div");
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  let run = null, state = null, seen = "", local = null, pending = null, sent = 0, line = null;

  bar.id = "tf-bar";
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", "Timeline");
  bar.innerHTML = `<output id="tf-time"></output>
    <div id="tf-buttons"><button id="tf-previous" title="previous stroke reversal">previous</button>
    <button id="tf-play" data-play aria-label="Play"></button>
    <button id="tf-next" title="next stroke reversal">next</button></div>
    <canvas id="tf-line"></canvas>
    <div id="tf-choices"><input id="tf-frame" type="number" min="0" step="1" aria-label="Frame">
    <select id="tf-loop" aria-label="Loop"></select><select id="tf-speed" aria-label="Speed"></select></div>`;

  // A drag asks for a frame no more often than the page looks; the cursor goes ahead of the answer.
  function seek(frame) {
    local = pending = clamp(Math.round(frame), 0, run.frames - 1);
  }

  function show() {
    const play = find("tf-play"), frame = find("tf-frame");
    document.body.classList.toggle("tf-dark", state.dark);
    play.textContent = state.playing ? "❚❚" : "▶\ufe0e";
    play.setAttribute("aria-label", state.playing ? "Pause" : "Play");
    find("tf-time").textContent = state.text;
    frame.max = run.frames - 1;
    if (document.activeElement !== frame) frame.value = state.frame;
    for (const name of ["speed", "loop"]) {
      const menu = find(`tf-${name}`), names = run[name === "speed" ? "speeds" : "loops"];
      if (menu.length !== names.length) menu.replaceChildren(...names.map((one) => new Option(one, one)));
      menu.value = state[name === "speed" ? "speed" : "loopName"];
    }
    for (const name of ["previous", "next"]) find(`tf-${name}`).disabled = !run.reversals.length;
    line.show(run, state, local);
  }

  function look() {
    requestAnimationFrame(look);
    const what = told("tf-run"), where = told("tf-state"), there = Boolean(what && where);
    if (there !== document.body.classList.contains("tf-on")) document.body.classList.toggle("tf-on", there);
    if (!there) { run = state = null; return; }
    if (!run || run.raw !== what) { run = {...JSON.parse(what), raw: what}; seen = ""; }
    if (pending !== null && performance.now() - sent > 15) {
      send("frame", pending);
      [sent, pending] = [performance.now(), null];
    }
    const now = `${where} ${innerWidth} ${innerHeight}`;
    if (now === seen && local === null) return;
    [state, seen] = [JSON.parse(where), now];
    const came = local !== null && pending === null && !line.dragging;
    if (came && (state.frame === local || performance.now() - sent > 2000)) local = null;
    show();
  }

  addEventListener("keydown", (event) => {
    const wish = run && timelineKey(event);
    if (!wish) return;
    event.preventDefault();
    event.stopPropagation();
    send(...wish);
  }, true);
  // A click on a chart over time seeks.
  addEventListener("click", (event) => {
    const [chart, over] = chartUnder(event);
    const beat = chart && run && { "t/T": 1, "t, ms": run.milliseconds }[chart.series[0].label];
    if (!beat) return;
    send("beats", chart.posToVal(event.clientX - over.getBoundingClientRect().left, "x") / beat);
  }, true);

  addEventListener("DOMContentLoaded", () => {
    document.body.append(bar);
    line = timeline(find("tf-line"), {seek, choose: (range) => send("range", range)});
    find("tf-play").onclick = () => send("play");
    find("tf-previous").onclick = () => send("reversal", -1);
    find("tf-next").onclick = () => send("reversal", 1);
    for (const name of ["speed", "loop"]) {
      find(`tf-${name}`).onchange = (event) => { send(name, event.target.value); event.target.blur(); };
    }
    find("tf-frame").onchange = (event) => { if (run) seek(+event.target.value || 0); };
    look();
  });
})();
