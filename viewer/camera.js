// The camera: saves what is seen of the scene, as PNG from the screen or as SVG from what the scene is made of.
//
// Private to viser: window.__viserMutable.{canvas, scene, requestRender, nodePoseData}, __viserSceneTree.
(() => {
  const {find, seen} = taichiflap;
  const box = document.createElement("div");
  box.id = "tf-camera";
  box.innerHTML = `<span>save</span>
    <button title="save what is seen as a picture">PNG</button><button title="save what is seen as a drawing">SVG</button>`;

  function save(content, ending) {
    const link = document.createElement("a"), frame = find("tf-frame");
    const number = document.body.classList.contains("tf-on") && frame ? `-${frame.value}` : "";
    link.href = URL.createObjectURL(content);
    link.download = `taichiflap${number}.${ending}`;
    link.click();
    setTimeout(() => URL.revokeObjectURL(link.href), 1000);
  }

  // The browser forgets what WebGL has drawn as soon as it is on the screen.
  function savePng() {
    const {canvas, scene, requestRender} = window.__viserMutable, before = scene.onAfterRender;
    scene.onAfterRender = (...all) => {
      scene.onAfterRender = before;
      before.apply(scene, all);
      canvas.toBlob((content) => save(content, "png"));
    };
    requestRender();
  }

  const hex = (colour) => `#${[0, 1, 2].map((i) => colour[i].toString(16).padStart(2, "0")).join("")}`;
  // Of lines that change their colour along them viser takes linear light.
  function screen(level) {
    const share = level / 255;
    return Math.round(255 * (share <= 0.0031308 ? 12.92 * share : 1.055 * share ** (1 / 2.4) - 0.055));
  }
  const ANCHORS = {left: "start", center: "middle", right: "end"}, SHIFT = {top: 12, center: 4, bottom: -3};

  function svg() {
    const {canvas, nodePoseData} = window.__viserMutable, nodes = window.__viserSceneTree.getState();
    const rect = canvas.getBoundingClientRect(), [left, top, right] = seen();
    const scale = rect.width / (right - left), dark = document.body.classList.contains("tf-dark")
      || document.documentElement.dataset.mantineColorScheme === "dark";
    const across = (x) => (scale * (x - left)).toFixed(2), down = (z) => (scale * (top - z)).toFixed(2);
    // What has a place of its own stands in groups that have none.
    const stand = (name) => (nodePoseData[name] || {position: [0, 0, 0]}).position;
    const parts = [], put = (depth, text) => parts.push([depth, text]);
    for (const [name, node] of Object.entries(nodes)) {
      if (!node || !node.message || !node.effectiveVisibility) continue;
      const {type, props} = node.message;
      if (type === "LineSegmentsMessage") {
        const many = props.colors.length > 3;
        for (let i = 0; i < props.points.length; i += 6) {
          const p = props.points.subarray(i, i + 6), c = many ? Array.from(props.colors.subarray(i, i + 3), screen) : props.colors;
          put(p[1], `<path d="M${across(p[0])} ${down(p[2])}L${across(p[3])} ${down(p[5])}" stroke="${hex(c)}"`
            + ` stroke-width="${props.thickness}" stroke-linecap="round"/>`);
        }
      } else if (type === "PointCloudMessage") {
        for (let i = 0; i < props.points.length; i += 3) {
          const p = props.points.subarray(i, i + 3), c = props.colors.length > 3 ? props.colors.subarray(i, i + 3) : props.colors;
          put(p[1], `<circle cx="${across(p[0])}" cy="${down(p[2])}" r="${(props.point_size * scale).toFixed(2)}" fill="${hex(c)}"/>`);
        }
      } else if (type === "ImageMessage") {
        const at = stand(name), w = props.render_width, h = props.render_height;
        const data = btoa(Array.from(props._data, (one) => String.fromCharCode(one)).join(""));
        put(1, `<image x="${across(at[0] - w / 2)}" y="${down(at[2] + h / 2)}" width="${scale * w}" height="${scale * h}"`
          + ` preserveAspectRatio="none" href="data:image/${props._format};base64,${data}"/>`);
      } else if (type === "LabelMessage" && props.text.trim()) {
        const at = stand(name), [vertical, horizontal] = props.anchor.split("-");
        const text = new XMLSerializer().serializeToString(document.createTextNode(props.text));
        put(-1, `<text x="${across(at[0])}" y="${+down(at[2]) + SHIFT[vertical]}" text-anchor="${ANCHORS[horizontal]}"`
          + ` font-size="${(14 * props.font_screen_scale).toFixed(1)}" fill="${dark ? "#e2e6ec" : "#282c34"}">${text}</text>`);
      }
    }
    parts.sort(([one], [other]) => other - one);
    return `<svg xmlns="http://www.w3.org/2000/svg" width="${rect.width}" height="${rect.height}"`
      + ` viewBox="0 0 ${rect.width} ${rect.height}" font-family="sans-serif"><rect width="100%" height="100%"`
      + ` fill="${dark ? "#141414" : "#ffffff"}"/>${parts.map(([, text]) => text).join("\n")}</svg>`;
  }

  function stay() {
    const page = window.__viserMutable, rect = page && page.canvas && page.canvas.getBoundingClientRect();
    box.style.display = rect && rect.width > 1 ? "flex" : "none";
    if (!rect) return;
    box.style.right = `${innerWidth - rect.right + 8}px`;
    box.style.top = `${rect.top + 8}px`;
  }
  addEventListener("DOMContentLoaded", () => {
    document.body.append(box);
    const [png, drawing] = box.querySelectorAll("button");
    png.onclick = savePng;
    drawing.onclick = () => save(new Blob([svg()], {type: "image/svg+xml"}), "svg");
    setInterval(stay, 300);
  });
})();
