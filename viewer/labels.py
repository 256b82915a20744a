"""The colours of the labels in the scene, which viser draws in black on white whatever the theme."""

from string import Template
from typing import Any

from . import wire
from .colours import Rgb, Theme

# The two shaders of viser's labels hold their colours as numbers. Labels come and go: look again now and then.
PAINT = Template(r"""
const paint = () => {
  const scene = window.__viserMutable && window.__viserMutable.scene;
  if (!scene) return;
  scene.traverse((node) => {
    const material = node.material;
    if (!material || !material.fragmentShader) return;
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
clearInterval(window.__taichiflapLabels);
window.__taichiflapLabels = setInterval(paint, 250);
paint();
""")


def paint(client: Any, theme: Theme) -> None:
    """Give a page's labels the colours of a theme; a viser that has changed keeps its own, which can be read too."""
    wire.run(client, PAINT.substitute(ink=_glsl(theme.ink), ground=_glsl(theme.background)))


def _glsl(colour: Rgb) -> str:
    return ", ".join(f"{part / 255.0:.3f}" for part in colour)
