"""Colours of a page's scene as the theme has them: viser draws labels in black on white, and shifts those of lines."""

from string import Template
from typing import Any

from . import wire
from .colours import Rgb, Theme

# The two shaders of viser's labels hold their colours as numbers; lines go through a film's response to light. Both
# come and go: look again now and then.
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
    """Give a page's labels and lines the colours of a theme; a viser that has changed shows colours near them."""
    wire.run(client, PAINT.substitute(ink=_glsl(theme.ink), ground=_glsl(theme.background)))


def _glsl(colour: Rgb) -> str:
    return ", ".join(f"{part / 255.0:.3f}" for part in colour)
