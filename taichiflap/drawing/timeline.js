// The timeline of a run, drawn and dragged: beats, stroke reversals, a curve, the loop's range and the place. The viewer
// and the shared page have it in common.
//
// `act` has seek(frame) and choose([first, last]). A run is {frames, perBeat, periodic, reversals, curve}, and `first`,
// the beats before its first frame, if there are any; a state is {frame, loop: [first, last], dark, text}.
function timeline(canvas, act) {
  const EDGE = 12, REACH = 6;
  let run = null, state = null, drag = null, local = null;
  const clamp = (value, low, high) => Math.min(Math.max(value, low), high);
  const width = () => canvas.clientWidth - 2 * EDGE;
  const placeOf = (frame) => EDGE + width() * frame / Math.max(run.frames - 1, 1);
  const frameAt = (place) => clamp((place - EDGE) / width(), 0, 1) * (run.frames - 1);
  canvas.setAttribute("role", "slider");
  canvas.setAttribute("aria-label", "Timeline");
  canvas.setAttribute("aria-valuemin", "0");
  canvas.tabIndex = 0;
  canvas.title = "drag: go; shift and drag: range of the loop; arrow keys: frames; page keys: beats; space: play";

  function draw() {
    if (!run || !state) return;
    const dense = devicePixelRatio || 1, w = canvas.clientWidth, h = canvas.clientHeight;
    if (canvas.width !== Math.round(w * dense)) canvas.width = Math.round(w * dense);
    if (canvas.height !== Math.round(h * dense)) canvas.height = Math.round(h * dense);
    const pen = canvas.getContext("2d"), top = 6, foot = h - 14, dark = state.dark;
    const [first, last] = drag && drag.range ? drag.range : state.loop;
    const line = (x, low, high) => { pen.moveTo(x, low); pen.lineTo(x, high); };
    const stroke = (colour, thick, path) => {
      pen.strokeStyle = colour; pen.lineWidth = thick; pen.beginPath(); path(); pen.stroke();
    };
    pen.setTransform(dense, 0, 0, dense, 0, 0);
    pen.clearRect(0, 0, w, h);
    pen.font = "11px sans-serif"; pen.textBaseline = "bottom"; pen.textAlign = "center";
    pen.fillStyle = dark ? "#2a3442" : "#e3eefb";
    pen.fillRect(placeOf(first), top, placeOf(last) - placeOf(first), foot - top);
    pen.fillStyle = dark ? "#c5cad2" : "#4b5563";
    const start = run.first || 0, beats = (run.frames - 1) / run.perBeat;
    const every = [1, 2, 5, 10, 20, 50, 100, 1000].find((n) => n * width() / beats > 22) || 10000;
    stroke(dark ? "#42464d" : "#ccd3db", 1, () => {
      for (let beat = Math.ceil(start - 1e-9); beat <= start + beats + 1e-9; beat++) {
        const x = placeOf((beat - start) * run.perBeat);
        if (width() / beats > 3 || beat % every === 0) line(x, top, foot + 3);
        if (run.periodic && beat % every === 0) pen.fillText(beat, x, h);
      }
    });
    stroke(dark ? "#8a919c" : "#8b95a1", 1, () => run.reversals.forEach((at) => line(placeOf(at), foot - 4, foot)));
    stroke(dark ? "#6ab0ff" : "#1c7ed6", 1.2, () => run.curve.forEach((value, i) => {
      const x = EDGE + width() * i / Math.max(run.curve.length - 1, 1), y = foot - 3 - value * (foot - top - 6);
      if (i) pen.lineTo(x, y); else pen.moveTo(x, y);
    }));
    pen.fillStyle = dark ? "#6ab0ff" : "#1c7ed6";
    for (const edge of [first, last]) pen.fillRect(placeOf(edge) - 2, top, 4, foot - top);
    const now = placeOf(local === null ? state.frame : local);
    pen.fillStyle = "#c81e2d";
    stroke("#c81e2d", 2, () => line(now, 0, foot + 4));
    pen.beginPath(); pen.arc(now, 5, 5, 0, 7); pen.fill();
  }

  // Shift and a drag choose the range of the loop, as does a drag of either of its ends.
  canvas.onpointerdown = (event) => {
    if (!run || !state) return;
    canvas.setPointerCapture(event.pointerId);
    const x = event.offsetX, end = state.loop.findIndex((frame) => Math.abs(placeOf(frame) - x) < REACH);
    drag = {};
    if (event.shiftKey) drag = {from: frameAt(x), range: [frameAt(x), frameAt(x)]};
    else if (end >= 0 && Math.abs(placeOf(state.frame) - x) > REACH) {
      drag = {from: state.loop[1 - end], range: [...state.loop]};
    } else act.seek(Math.round(frameAt(x)));
  };
  canvas.onpointermove = (event) => {
    if (!drag || !run) return;
    const frame = frameAt(event.offsetX);
    if (!drag.range) { act.seek(Math.round(frame)); return; }
    drag.range = [Math.min(drag.from, frame), Math.max(drag.from, frame)].map(Math.round);
    draw();
  };
  canvas.onpointerup = canvas.onpointercancel = () => {
    if (drag && drag.range && run) act.choose(drag.range);
    drag = null;
  };

  return {
    // Show a run where it stands; `ahead` is a frame that was asked for and has not come yet.
    show(newRun, newState, ahead = null) {
      [run, state, local] = [newRun, newState, ahead];
      canvas.setAttribute("aria-valuemax", run.frames - 1);
      canvas.setAttribute("aria-valuenow", Math.round(state.frame));
      canvas.setAttribute("aria-valuetext", state.text);
      draw();
    },
    get dragging() { return Boolean(drag); },
  };
}

// What a key asks for, as [what, value]; null for a key of no meaning here, or of the control that it is typed into.
function timelineKey(event) {
  const wanted = {
    " ": ["play", null], "Home": ["edge", 0], "End": ["edge", 1],
    "ArrowLeft": ["skip", event.shiftKey ? -10 : -1], "ArrowRight": ["skip", event.shiftKey ? 10 : 1],
    "PageUp": ["beat", -1], "PageDown": ["beat", 1],
  }[event.key];
  const inside = (names) => event.target.closest && event.target.closest(names);
  if (!wanted || event.ctrlKey || event.altKey || event.metaKey) return null;
  if (inside("input,textarea,select,[contenteditable],[role=dialog],[role=listbox]")) return null;
  if (inside("[role=slider]:not(canvas)") && event.key !== " ") return null;
  if (event.key === " " && inside("button:not([data-play]),a,[role=tab],[role=checkbox]")) return null;
  return wanted;
}
