"""How far a picture of leafseason is from the path traced picture of its own GLB, against processor time.

    scenes/path_traced.py OUT [leafseason]

Needs numpy, pillow, mitsuba 3 (and an LLVM that it finds), and a leafseason built with `--features exr`. Draws
scenes/bench-10k.toml in 960 x 540 pixels with leaves that look as glTF shows them (matte, alike on both sides, without relief)
and with few and many samples, path traces the GLB with thin leaves that reflect and let light through, each its own colour,
under the same sun and sky, and writes path_traced.csv: processor seconds, RMSE in linear light (radiance x exposure) and
mean FLIP of the part of the picture that holds the crown. Ours are cold: they count all of the raster stage. Mitsuba's count
its samples alone.
"""
import csv, io, json, os, struct, subprocess, sys, time
import numpy as np
from PIL import Image
import mitsuba as mi
mi.set_variant("llvm_ad_rgb")
import drjit as dr


class Leaf(mi.BSDF):
    """Diffuse on both sides; what is let through has a colour of its own."""

    def __init__(self, props):
        super().__init__(props)
        self.reflectance, self.transmittance = props["reflectance"], props["transmittance"]
        sides = mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide
        lobes = [mi.BSDFFlags.DiffuseReflection | sides, mi.BSDFFlags.DiffuseTransmission | sides]
        self.m_components, self.m_flags = [int(lobe) for lobe in lobes], int(lobes[0]) | int(lobes[1])

    def colours(self, si, active):
        reflected, through = self.reflectance.eval(si, active), self.transmittance.eval(si, active)
        sums = dr.maximum(mi.luminance(reflected) + mi.luminance(through), 1e-6)
        return reflected, through, mi.luminance(reflected) / sums

    def sample(self, ctx, si, which, where, active):
        reflected, through, share = self.colours(si, active)
        is_reflected = which < share
        wo = mi.warp.square_to_cosine_hemisphere(where)
        sample = dr.zeros(mi.BSDFSample3f)
        sample.pdf = mi.warp.square_to_cosine_hemisphere_pdf(wo) * dr.select(is_reflected, share, 1 - share)
        wo.z = dr.mulsign(wo.z, si.wi.z * dr.select(is_reflected, 1.0, -1.0))
        sample.wo, sample.eta = wo, 1.0
        flags = [mi.BSDFFlags.DiffuseReflection, mi.BSDFFlags.DiffuseTransmission]
        sample.sampled_type = dr.select(is_reflected, mi.UInt32(int(flags[0])), mi.UInt32(int(flags[1])))
        sample.sampled_component = dr.select(is_reflected, mi.UInt32(0), mi.UInt32(1))
        weight = dr.select(is_reflected, reflected / dr.maximum(share, 1e-6), through / dr.maximum(1 - share, 1e-6))
        return sample, weight & (active & (si.wi.z != 0))

    def eval(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[0]

    def pdf(self, ctx, si, wo, active):
        return self.eval_pdf(ctx, si, wo, active)[1]

    def eval_pdf(self, ctx, si, wo, active):
        reflected, through, share = self.colours(si, active)
        is_reflected, cosine = si.wi.z * wo.z > 0, dr.abs(wo.z) * dr.inv_pi
        value = dr.select(is_reflected, reflected, through) * cosine
        return value & active, dr.select(active, cosine * dr.select(is_reflected, share, 1 - share), 0)

    def traverse(self, callback):
        pass

    def to_string(self):
        return "Leaf[]"


mi.register_bsdf("leaf", Leaf)
KINDS = {5121: np.uint8, 5123: np.uint16, 5125: np.uint32, 5126: np.float32, 5120: np.int8, 5122: np.int16}
WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}


class Glb:
    """Meshes, materials and where they stand."""

    def __init__(self, path):
        data = open(path, "rb").read()
        length = struct.unpack_from("<I", data, 12)[0]
        self.json, self.bytes = json.loads(data[20:20 + length]), data[28 + length:]

    def view(self, number):
        view = self.json["bufferViews"][number]
        start = view.get("byteOffset", 0)
        return self.bytes[start:start + view["byteLength"]], view.get("byteStride")

    def values(self, number):
        accessor = self.json["accessors"][number]
        (data, stride), width = self.view(accessor["bufferView"]), WIDTHS[accessor["type"]]
        kind, offset, count = np.dtype(KINDS[accessor["componentType"]]), accessor.get("byteOffset", 0), accessor["count"]
        stride = stride or kind.itemsize * width
        raw = np.ndarray((count, width), kind, data, offset, (stride, kind.itemsize))
        return raw.astype("f8") / np.iinfo(kind).max if accessor.get("normalized") else raw

    def picture(self, texture):
        source = self.json["textures"][texture]["source"]
        return np.asarray(Image.open(io.BytesIO(self.view(self.json["images"][source]["bufferView"])[0])).convert("RGB"))

    def placed(self):
        """(mesh, matrix) of all that stands in the scene."""
        todo = [(n, np.eye(4)) for n in self.json["scenes"][self.json.get("scene", 0)]["nodes"]]
        while todo:
            number, above = todo.pop()
            node = self.json["nodes"][number]
            own = above @ (np.array(node["matrix"], float).reshape(4, 4).T if "matrix" in node else
                           laid(*[np.array([node.get(k, d)], float) for k, d in PLACE])[0])
            todo += [(child, own) for child in node.get("children", [])]
            if "mesh" not in node:
                continue
            at = node.get("extensions", {}).get("EXT_mesh_gpu_instancing", {}).get("attributes")
            if at is None:
                yield node["mesh"], own
                continue
            found = {k: self.values(at[k.upper()]) for k, _ in PLACE if k.upper() in at}
            count = len(next(iter(found.values())))
            for matrix in laid(*[found.get(k, np.tile(d, (count, 1))) for k, d in PLACE]):
                yield node["mesh"], own @ matrix


PLACE = [("translation", [0, 0, 0]), ("rotation", [0, 0, 0, 1]), ("scale", [1, 1, 1])]


def laid(moved, turned, scaled):
    x, y, z, w = (np.asarray(turned, float) / np.linalg.norm(turned, axis=1, keepdims=True)).T
    m = np.zeros((len(x), 4, 4))
    m[:, 0, 0], m[:, 0, 1], m[:, 0, 2] = 1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)
    m[:, 1, 0], m[:, 1, 1], m[:, 1, 2] = 2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)
    m[:, 2, 0], m[:, 2, 1], m[:, 2, 2] = 2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)
    m[:, :3, :3] *= np.asarray(scaled, float)[:, None, :]
    m[:, :3, 3], m[:, 3, 3] = moved, 1
    return m


def linear(codes):
    x = codes / 255.0
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


def bitmap(colours):
    return {"type": "bitmap", "bitmap": mi.Bitmap(np.ascontiguousarray(colours, np.float32)), "raw": True}


def bsdf(glb, material):
    core, more = material["pbrMetallicRoughness"], material.get("extensions", {}).get("KHR_materials_diffuse_transmission")
    factor = np.array(core.get("baseColorFactor", [1, 1, 1, 1])[:3])
    picture = core.get("baseColorTexture")
    base = linear(glb.picture(picture["index"])) * factor if picture else np.tile(factor, (2, 2, 1))
    if more is None:
        return {"type": "twosided", "nested": {"type": "diffuse", "reflectance": bitmap(base)}}
    share, tint = more["diffuseTransmissionFactor"], more.get("diffuseTransmissionColorTexture")
    through = linear(glb.picture(tint["index"])) if tint else np.tile(more["diffuseTransmissionColorFactor"], (2, 2, 1))
    return {"type": "leaf", "reflectance": bitmap(base), "transmittance": bitmap(share * through)}


def sky(program, out, view):
    """The sky as Mitsuba lays it out: the zenith above, azimuth from -z towards +x; what lies below is the horizon's."""
    high, wide = 512, 1024
    polar, around = np.meshgrid((np.arange(high) + 0.5) / high * np.pi, (np.arange(wide) + 0.5) / wide * 2 * np.pi, indexing="ij")
    polar = np.where(polar > np.pi / 2, np.pi / 2 + 0.02, polar)
    way = np.stack([np.sin(polar) * np.sin(around), np.cos(polar), -np.sin(polar) * np.cos(around)], -1)
    result, nearest = np.zeros((high, wide, 3), np.float32), np.max(np.abs(way), -1)
    for name, ahead in {"px": [1, 0, 0], "nx": [-1, 0, 0], "pz": [0, 0, 1], "nz": [0, 0, -1], "py": [0, 1, 0]}.items():
        ahead = np.array(ahead, float)
        level = ahead if name != "py" else np.array([0, 0, 1.0])
        right = np.cross(level, [0, 1, 0])
        up = np.cross(right, ahead)
        picture, exposure = face(program, out, name, view, (ahead, level, right))
        here, size = way @ ahead >= nearest - 1e-9, len(picture)
        over = (way[here] @ np.stack([right, -up], -1)) / (way[here] @ ahead)[:, None]
        across, down = ((over * 0.5 + 0.5) * size - 0.5).clip(0, size - 1.001).T
        c, r = across.astype(int), down.astype(int)
        a, b = (across - c)[:, None], (down - r)[:, None]
        upper, lower = (picture[row, c] * (1 - a) + picture[row, c + 1] * a for row in (r, r + 1))
        result[here] = view["exposure"] / exposure * (upper * (1 - b) + lower * b)
    return result


def face(program, out, name, view, axes):
    """A picture of 90 degrees of the sky far from the tree, and its exposure. The sun's azimuth is told from the look's."""
    ahead, level, right = axes
    sun, eye = np.array(view["sun"]), np.array([3000.0, 10.0, 3000.0])
    azimuth = np.degrees(np.arctan2(sun @ right, -(sun @ level))) % 360
    target = eye + 1000 * ahead + level
    sets = [f"camera.position={eye.tolist()}", f"camera.target={target.tolist()}", "camera.field_of_view=90.0",
            f"light.sun_azimuth={azimuth}", "light.sun=0", "light.exposure_value=12", "tree.age=3",
            "image.width=256", "image.height=256"]
    report = drawn(program, f"{out}/{name}", sets)
    return read(f"{out}/{name}/bench-10k.exr"), report["frames"][0]["view"]["exposure"]


def drawn(program, out, sets):
    """Draws scenes/bench-10k.toml with these assignments; the report."""
    here = os.path.dirname(os.path.abspath(__file__))
    call = [program, "render", f"{here}/bench-10k.toml", "--out", out, "--report", f"{out}.json", "--force", "--progress", "none"]
    sets = ["output.exr=true", "image.background=sky"] + sets
    call += [word for one in sets for word in ("--set", one)]
    subprocess.run(call, check=True, stderr=subprocess.DEVNULL)
    return json.load(open(f"{out}.json"))


def read(path):
    return np.array(mi.Bitmap(path).convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False))


def traced(scene, samples, seed):
    """A picture of so many samples, and its processor seconds."""
    start, total = time.process_time(), 0
    for part in range(0, samples, 16):
        some = min(16, samples - part)
        image = mi.render(scene, spp=some, seed=seed + part)
        dr.eval(image)
        total = total + np.array(image, np.float64) * some
    return total / samples, time.process_time() - start


def toned(light):
    """The Khronos PBR Neutral tone curve and the sRGB encoding, as the program's own pictures have them: codes of 8 bits."""
    least = light.min(-1, keepdims=True)
    light = light - np.where(least < 0.08, least - 6.25 * least * least, 0.04)
    peak = light.max(-1, keepdims=True)
    bent = 1 - 0.24 * 0.24 / np.maximum(peak - 0.52, 0.24)
    share = 1 / (0.15 * (peak - bent) + 1)
    pressed = light * (bent / np.maximum(peak, 1e-6)) * share + bent * (1 - share)
    light = np.where(peak < 0.76, light, pressed).clip(0, 1)
    return (np.where(light <= 0.0031308, 12.92 * light, 1.055 * light ** (1 / 2.4) - 0.055) * 255 + 0.5).astype(np.uint8)


def distance(program, out, found, exact):
    """RMSE in linear light and mean FLIP of the crown."""
    crowns = [np.maximum(light[CROWN], 0.0) for light in (found, exact)]
    names = [f"{out}/found.png", f"{out}/exact.png"]
    for name, crown in zip(names, crowns):
        Image.fromarray(toned(crown)).save(name)
    told = subprocess.run([program, "compare", *names], capture_output=True, text=True)
    return np.sqrt(np.mean((crowns[0] - crowns[1]) ** 2)), float((told.stdout + told.stderr).split("FLIP ")[1].split()[0])


def scene(glb, view, around):
    """The scene as Mitsuba takes it: leaves flattened, which it draws faster than instances."""
    materials = [mi.load_dict(bsdf(glb, m)) for m in glb.json["materials"]]
    parts = {}
    for number, matrix in glb.placed():
        for primitive in glb.json["meshes"][number]["primitives"]:
            parts.setdefault(id(primitive), (primitive, []))[1].append(matrix)
    content = {"type": "scene", "integrator": {"type": "path", "max_depth": DEPTH, "rr_depth": 1000}}
    for count, (primitive, matrices) in enumerate(parts.values()):
        at = primitive["attributes"]
        position, normal, uv = (np.asarray(glb.values(at[k]), float) for k in ("POSITION", "NORMAL", "TEXCOORD_0"))
        index, matrices = glb.values(primitive["indices"]).reshape(-1, 3), np.array(matrices)
        places = np.einsum("nij,vj->nvi", matrices[:, :3, :3], position) + matrices[:, None, :3, 3]
        normals = np.einsum("nij,vj->nvi", np.linalg.inv(matrices[:, :3, :3]).transpose(0, 2, 1), normal)
        normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
        faces = (index[None] + (np.arange(len(matrices)) * len(position))[:, None, None]).reshape(-1, 3)
        properties = mi.Properties(); properties["bsdf"] = materials[primitive["material"]]
        mesh = mi.Mesh(f"part{count}", places.shape[0] * places.shape[1], len(faces), properties, True, True)
        values = mi.traverse(mesh)
        values["vertex_positions"] = places.reshape(-1).astype("f4"); values["vertex_normals"] = normals.reshape(-1).astype("f4")
        values["vertex_texcoords"] = np.tile(uv, (len(matrices), 1)).reshape(-1).astype("f4")
        values["faces"] = faces.reshape(-1).astype("u4"); values.update()
        content[f"part{count}"] = mesh
    exposure = view["exposure"]
    content["sensor"] = {
        "type": "perspective", "fov": view["field_of_view"], "fov_axis": "y", "near_clip": 0.01, "far_clip": 1e4,
        "to_world": mi.ScalarTransform4f().look_at(view["position"], view["target"], [0, 1, 0]),
        "film": {"type": "hdrfilm", "width": SIZE[0], "height": SIZE[1], "rfilter": {"type": "box"}, "pixel_format": "rgb"},
        "sampler": {"type": "independent"}}
    content["sun"] = {"type": "directional", "direction": [-x for x in view["sun"]],
                      "irradiance": {"type": "rgb", "value": [e * exposure for e in view["sun_irradiance"]]}}
    content["sky"] = {"type": "envmap", "bitmap": mi.Bitmap(around)}
    return mi.load_dict(content)


SIZE, CROWN, DEPTH, REFERENCE = (960, 540), np.s_[30:380, 340:600], 24, 512
ALIKE = ["colour.gloss=false", "colour.painting.lower_side=false", "colour.painting.relief=0", "image.width=960",
         "image.height=540"]


def main():
    out, program = sys.argv[1], sys.argv[2] if len(sys.argv) > 2 else "target/release/leafseason"
    os.makedirs(out, exist_ok=True)
    ours = {n: drawn(program, f"{out}/ours-{n}", ALIKE + [f"image.samples={n}"]) for n in (1, 4, 8, 16, 32, 64)}
    view = ours[8]["frames"][0]["view"]
    tree = scene(Glb(f"{out}/ours-8/bench-10k.glb"), view, sky(program, out, view))
    traced(tree, 1, 0)
    exact, _ = traced(tree, REFERENCE, 1_000_000)
    mi.Bitmap(exact.astype(np.float32)).write(f"{out}/path_traced.exr")
    rows = []
    for n, report in ours.items():
        raster = next(stage for stage in report["stages"] if stage["name"] == "raster")
        picture = read(f"{out}/ours-{n}/bench-10k.exr")
        rows.append(["leafseason", n, raster["figures"]["cpu_seconds"], *distance(program, out, picture, exact)])
    for n in (1, 2, 4, 8, 16, 32):
        picture, seconds = traced(tree, n, 1000 * n)
        rows.append(["path tracing", n, seconds, *distance(program, out, picture, exact)])
    with open(f"{out}/path_traced.csv", "w", newline="") as file:
        table = csv.writer(file)
        table.writerow(["program", "samples", "cpu_s", "rmse_linear", "flip_mean"])
        table.writerows(rows)
    for name, samples, *figures in rows:
        print(f"{name:12} {samples:3} samples  {figures[0]:7.3f} s  RMSE {figures[1]:.4f}  FLIP {figures[2]:.4f}")


main()
