"""Theme colours in a page's scene: viser draws labels in black on white, and changes colours of lines."""

from string import Template
from typing import Any

from . import wire
from .colours import Rgb, Theme

# The colours of viser's labels are constants in two shaders, and lines are tone-mapped. Both are created dynamically,
# so that the script runs repeatedly.
PAINT = Template(r"""
const paint = () => {
  const scene = window.__viserMutable && window.__viserMutable.scene;
  if (!scene) return;
  scene.traverse((node) => {
    const material = node.material;
    if (!material) return;
    if (material.toneMapped && node.geometry.isLineSegmentsGeometry) {
      material.toneMapped = false;
      material.needsUpdate = true;
    }
    if (!material.fragmentShader) return;
    const own = material.userData.own || material.fragmentShader;
    const mine = own
      .replace(/vec4\(\s*0\.0,\s*0\.0,\s*0\.0,\s*a\s*\)/, "vec4($ink, a)")
      .replace(/vec4\(\s*1\.0,\s*1\.0,\s*1\.0,\s*0\.85/, "vec4($ground, 0.6");
    if (mine === own || mine === material.fragmentShader) return;
    material.userData.own = own;
    material.fragmentShader = mine;
    material.needsUpdate = true;
  });
};
clearInterval(window.__taichiflapPaint);
window.__taichiflapPaint = setInterval(paint, 250);
paint();
""")


def paint(client: Any, theme: Theme) -> None:
    """Give a page's labels and lines the colours of a theme; with another version of viser they differ slightly."""
    wire.run(client, PAINT.substitute(ink=_glsl(theme.ink), ground=_glsl(theme.background)))


def _glsl(colour: Rgb) -> str:
    return ", ".join(f"{part / 255.0:.3f}" for part in colour)
