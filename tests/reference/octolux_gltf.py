"""octolux's BRDF (simulator/brdf.py) as a BSDF of Mitsuba 3, written from the formulas there: `octolux_gltf`.

Parameters as `principled`: base_color, roughness, metallic, specular (0.5 is an F0 of 0.04). It reflects on both sides:
the shading normal is turned to the side of the geometric normal that is seen, and light from the other side of the
surface brings nothing. Import it when a variant is set.
"""

from __future__ import annotations

from typing import Any

import drjit as dr
import mitsuba as mi

from octolux.simulator.brdf import DIELECTRIC_F0, MIN_ROUGHNESS


class OctoluxGltf(mi.BSDF):
    """f = (1 - F) c / pi + F D V."""

    def __init__(self, props: Any):
        super().__init__(props)
        self.base_color = props.get_texture("base_color", 0.5)
        self.roughness = props.get_texture("roughness", 1.0)
        self.metallic = props.get_texture("metallic", 0.0)
        self.weight = 2.0 * props.get("specular", 0.5)
        both = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        self.m_components = [mi.BSDFFlags.DiffuseReflection | both, mi.BSDFFlags.GlossyReflection | both]
        self.m_flags = self.m_components[0] | self.m_components[1]

    def _side(self, si: Any) -> Any:
        """+1 or -1: the side of the geometric surface that is seen."""
        return dr.select(dr.dot(si.n, si.to_world(si.wi)) >= 0.0, 1.0, -1.0)

    def _alpha(self, si: Any, active: Any) -> Any:
        roughness = dr.maximum(self.roughness.eval_1(si, active), MIN_ROUGHNESS)
        return roughness * roughness

    def _distribution(self, cosine: Any, alpha: Any) -> Any:
        square = alpha * alpha
        return square / (dr.pi * dr.square(cosine * cosine * (square - 1.0) + 1.0))

    def eval_pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        side = self._side(si)
        wi, wo_up = _turned(si.wi, side), _turned(wo, side)
        n_v, n_l = wi.z, wo_up.z
        above = active & (n_v > 0.0) & (n_l > 0.0)
        half = dr.normalize(wi + wo_up)
        alpha = self._alpha(si, active)
        v_dot_h = dr.clip(dr.dot(wi, half), 0.0, 1.0)
        density = self._distribution(half.z, alpha)
        # Half of the samples by the cosine, half by D n.h; dl = 4 v.h dh.
        pdf = 0.5 * n_l / dr.pi + 0.5 * density * half.z / (4.0 * dr.maximum(v_dot_h, 1e-12))
        value = self._brdf(si, n_v, n_l, v_dot_h, density, alpha, active) * n_l
        seen = above & (dr.dot(si.n, si.to_world(wo)) * side > 0.0)
        return dr.select(seen, value, 0.0), dr.select(above, pdf, 0.0)

    def _brdf(self, si: Any, n_v: Any, n_l: Any, v_dot_h: Any, density: Any, alpha: Any, active: Any) -> Any:
        color, metallic = self.base_color.eval(si, active), self.metallic.eval_1(si, active)
        f0 = DIELECTRIC_F0 * self.weight * (1.0 - metallic) + color * metallic
        f90 = self.weight * (1.0 - metallic) + metallic
        fresnel = f0 + (f90 - f0) * (1.0 - v_dot_h) ** 5
        square = alpha * alpha
        smith = n_l * dr.sqrt(square + (1.0 - square) * n_v * n_v) + n_v * dr.sqrt(square + (1.0 - square) * n_l * n_l)
        return (1.0 - fresnel) * color * (1.0 - metallic) / dr.pi + fresnel * density * 0.5 / smith

    def eval(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx: Any, si: Any, wo: Any, active: Any = True) -> Any:
        return self.eval_pdf(ctx, si, wo, active)[1]

    def sample(self, ctx: Any, si: Any, sample1: Any, sample2: Any, active: Any = True) -> Any:
        side = self._side(si)
        wi = _turned(si.wi, side)
        alpha = self._alpha(si, active)
        cosine = dr.sqrt((1.0 - sample2.x) / (1.0 + (alpha * alpha - 1.0) * sample2.x))
        sine = dr.safe_sqrt(1.0 - cosine * cosine)
        around = 2.0 * dr.pi * sample2.y
        half = mi.Vector3f(sine * dr.cos(around), sine * dr.sin(around), cosine)
        mirrored = 2.0 * dr.dot(wi, half) * half - wi
        wo = _turned(dr.select(sample1 < 0.5, mi.warp.square_to_cosine_hemisphere(sample2), mirrored), side)
        value, pdf = self.eval_pdf(ctx, si, wo, active)
        found = active & (pdf > 0.0)
        sample = dr.zeros(mi.BSDFSample3f)
        sample.wo, sample.pdf, sample.eta = wo, dr.select(found, pdf, 0.0), 1.0
        sample.sampled_type = mi.UInt32(+mi.BSDFFlags.GlossyReflection)
        sample.sampled_component = mi.UInt32(1)
        return sample, dr.select(found, value / pdf, 0.0)

    def traverse(self, callback: Any) -> None:
        for name in ("base_color", "roughness", "metallic"):
            callback.put(name, getattr(self, name), mi.ParamFlags.Differentiable)

    def to_string(self) -> str:
        return "OctoluxGltf[]"


def _turned(direction: Any, side: Any) -> Any:
    return mi.Vector3f(direction.x, direction.y, direction.z * side)


mi.register_bsdf("octolux_gltf", OctoluxGltf)
