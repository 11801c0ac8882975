"""The artists' files, how many samples they get, and why some differ from Cycles."""

from support.references import Case

FIREFLIES = "noise: rare bright reflections of a small lamp (p is not small)"

CASES = (
    Case("armory-particles", "particle_hair.blend", 16, matches=True),
    Case("armory-sss", "material_sss.blend", 16, cause="subsurface scattering is diffuse"),
    Case("bevy-panorama", "scene.blend", 64, matches=True),
    Case("graphene-device", "device.blend", 16, matches=True),
    Case("ignis-bumpmap", "evaluation/blender/bumpmap.blend", 32, cause=FIREFLIES),
    Case("ignis-glass", "flipped-prim.blend", 128, matches=True),
    Case("ignis-lights", "lights.blend", 128, matches=True),
    Case("ignis-mix", "mix.blend", 64, matches=True),
    Case("ignis-normalmap", "evaluation/blender/normalmap.blend", 32, cause=FIREFLIES),
    Case("ignis-principled", "evaluation/blender/principled.blend", 32),
    Case("ignis-sun", "sun.blend", 64, matches=True),
    Case("ignis-technique", "scene.blend", 64, matches=True),
    Case("nodevember-flower", "10_flower.blend", 16),
    Case("nodevember-planet", "23_planet.blend", 16),
    Case("nodevember-reptile", "06_reptile.blend", 16),
    Case("nodevember-snow", "05_snow.blend", 16),
    Case("techmeetup-caustics", "caustics.blend", 32),
    Case("techmeetup-cornell", "cornel_box.blend", 64, matches=True),
    Case("techmeetup-dof", "depth_of_field.blend", 32, matches=True),
    Case("techmeetup-motionblur", "motion_blur_moving.blend", 16, matches=True),
)
