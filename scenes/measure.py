"""What the program is held to, measured: one table of what was asked and what was found.

    scenes/measure.py OUT [--program leafseason] [--rivals COMMAND] [--rounds 3] [--only NAME ...]

NAMES: frames, detail, cold, memory and threads when none is given; film, which takes minutes; scenes, which writes into OUT
what other renderers need: the GLB of each timed scene with its camera and light. Needs Python alone, a machine that does
nothing else, and a release build.

`--rivals` is a command that draws a GLB: it is called as COMMAND NAME in.glb out.png WIDTH HEIGHT, with NAME pyrender or
mitsuba-direct, SHADOWS 0 or 1, AA the samples of a pixel and REPS frames after the first in the environment. It finds camera
and light in NAME.view.json beside the GLB (metres, y up, fovy in degrees, light_dir from the sun) and ends with a line of JSON
that holds "frame_s", the median of the later frames, and "whole_s", the whole process, seconds. Ours and theirs are drawn in
turns, so that a machine that grows slower is so for both; the ratio is that of the medians.
"""
import argparse, json, os, re, statistics, subprocess, sys, time

HERE = os.path.dirname(os.path.abspath(__file__))
# Scene, what is set, the rival with its shadows and samples, the least ratio that is asked.
FRAMES = [
    ("bench-10k", ["light.shadow_size=0"], ("pyrender", 0, 4), 4),
    ("bench-10k", [], ("pyrender", 1, 4), 5),
    ("bench-10k", [], ("mitsuba-direct", 1, 4), 3),
    ("bench-100k", ["light.shadow_size=0", "image.samples=4"], ("pyrender", 0, 4), 8),
    ("bench-100k", ["image.samples=4"], ("pyrender", 1, 4), None),
    ("bench-1m", ["light.shadow_size=0"], ("pyrender", 0, 4), 8),
]
WITHOUT_DETAIL = ["image.lod_error=0"]
LATER = {"bench-10k": 12, "bench-100k": 8, "bench-1m": 4}
rows = []


def row(what, asked, found, is_met=None):
    rows.append((what, asked, found, "" if is_met is None else "yes" if is_met else "NO"))
    print(" | ".join(rows[-1]), flush=True)


class Program:
    def __init__(self, path, out):
        self.path, self.out, self.peak = os.path.abspath(path), out, 0

    def render(self, scene, sets=(), extra=()):
        """The report of a run in an empty folder, with its wall seconds; keeps the most memory that it took, MB."""
        folder = os.path.join(self.out, "run")
        subprocess.run(["rm", "-rf", folder], check=True)
        report = os.path.join(self.out, "run.json")
        command = [self.path, "render", scene, "--out", folder, "--report", report, *extra]
        command += [part for one in sets for part in ("--set", one)]
        start = time.monotonic()
        done = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        told = done.stderr.read()
        _, status, usage = os.wait4(done.pid, 0)
        seconds = time.monotonic() - start
        if status:
            sys.exit(f"{' '.join(command)}\n{told}")
        self.peak = usage.ru_maxrss / 1024
        return json.load(open(report)), seconds

    def turntable(self, name):
        """A scene of which every frame is seen from another side, in which nothing else changes."""
        text = open(os.path.join(HERE, name + ".toml")).read()
        text = re.sub(r"(?m)^gltf.*\n", "", text)
        day, count = float(re.search(r"(?m)^day = ([\d.]+)", text)[1]), LATER[name]
        text = re.sub(r"(?m)^day = .*$", f"from = {day}\nto = {day + 1e-8 * count:.8f}\nstep = 0.00000001", text)
        path = os.path.join(self.out, name + "-turntable.toml")
        open(path, "w").write(text)
        return path

    def frame(self, name, sets):
        """Median seconds of a turntable's frames after the first."""
        report, _ = self.render(self.turntable(name), [*sets, "camera.turn=9"])
        return statistics.median([frame["seconds"] for frame in report["frames"]][1:])


def drawn_by(options, name, rival, shadows, samples, later):
    """What a rival tells of drawing a GLB in OUT, with so many frames after the first."""
    glb, picture = (os.path.join(options.out, file) for file in (name + ".glb", "rival.png"))
    called = [*options.rivals.split(), rival, glb, picture, "1920", "1080"]
    settings = {"AA": str(samples), "SHADOWS": str(shadows), "REPS": str(later), "MI_INSTANCES": "0"}
    done = subprocess.run(called, env={**os.environ, **settings}, capture_output=True, text=True)
    lines = [line for line in done.stdout.splitlines() if '"whole_s"' in line]
    if not lines:
        sys.exit(f"{' '.join(called)}\n{done.stdout}{done.stderr}")
    return json.loads(lines[-1])


def write_view(options, name, report):
    """The camera and the light of a report's first frame, as `--rivals` reads them."""
    view = report["frames"][0]["view"]
    told = {"eye": view["position"], "target": view["target"], "up": [0, 1, 0], "fovy": view["field_of_view"], "near": 0.1,
            "far": 400.0, "light_dir": [-s for s in view["sun"]], "light": 2.2, "ambient": 0.5, "background": [0.5, 0.6, 0.7]}
    json.dump(told, open(os.path.join(options.out, name + ".view.json"), "w"), indent=1)


def scenes(program, options):
    """Writes the GLB of each timed scene with its camera, where it is not there yet."""
    for name in ("bench-10k", "bench-100k", "bench-1m", "maple"):
        if not os.path.exists(os.path.join(options.out, name + ".view.json")):
            report, _ = program.render(os.path.join(HERE, name + ".toml"))
            os.replace(os.path.join(options.out, "run", name + ".glb"), os.path.join(options.out, name + ".glb"))
            write_view(options, name, report)


def seconds(values):
    return f"{statistics.median(values):.3f} s ({min(values):.3f} to {max(values):.3f})"


def frames(program, options):
    for name, sets, (rival, shadows, samples), least in FRAMES:
        ours, plain, theirs = [], [], []
        for _ in range(options.rounds):
            ours.append(program.frame(name, sets))
            plain.append(program.frame(name, [*sets, *WITHOUT_DETAIL]))
            if options.rivals:
                theirs.append(drawn_by(options, name, rival, shadows, samples, 4)["frame_s"])
        what = " ".join([name, *sets])
        if theirs:
            ratio = statistics.median(theirs) / statistics.median(ours)
            found = f"{ratio:.1f}x: {seconds(ours)} against {seconds(theirs)}"
            row(f"{what}, {rival}", f"{least}x" if least else "", found, ratio >= least if least else None)
        else:
            row(what, "", seconds(ours))
        row(f"{what}, no level of detail", "", seconds(plain))


def detail(program, _):
    pictures = []
    for sets in ([], WITHOUT_DETAIL):
        program.render(os.path.join(HERE, "bench-1m.toml"), sets)
        pictures.append(os.path.join(program.out, f"detail-{len(pictures)}.png"))
        os.replace(os.path.join(program.out, "run", "bench-1m.png"), pictures[-1])
    told = subprocess.run([program.path, "compare", *pictures], capture_output=True, text=True).stdout
    error = float(re.search(r"(?i)rmse[^\d]*([\d.eE+-]+)", told)[1])
    row("bench-1m, levels of detail against none, RMSE in linear light", "2/255", f"{error * 255:.2f}/255", error <= 2 / 255)


def cold(program, options):
    ours, theirs = [], []
    for _ in range(3 * options.rounds):
        ours.append(program.render(os.path.join(HERE, "maple.toml"))[1])
        if options.rivals:
            theirs.append(drawn_by(options, "maple", "pyrender", 1, 4, 0)["whole_s"])
    what = "maple.toml, the whole process to PNG and GLB"
    if theirs:
        ratio = statistics.median(theirs) / statistics.median(ours)
        row(f"{what}, pyrender from the GLB", "4x", f"{ratio:.1f}x: {seconds(ours)} against {seconds(theirs)}", ratio >= 4)
    else:
        row(what, "", seconds(ours))


def memory(program, _):
    for name, most in (("bench-10k", 300), ("bench-1m", 600)):
        program.render(os.path.join(HERE, name + ".toml"))
        row(f"{name}, PNG and GLB, peak memory", f"{most} MB", f"{program.peak:.0f} MB", program.peak <= most)
        program.render(program.turntable(name), ["camera.turn=9"])
        row(f"{name}, turntable, peak memory", f"{most} MB", f"{program.peak:.0f} MB", program.peak <= most)


def threads(program, options):
    def raster(count):
        report, _ = program.render(program.turntable("bench-10k"), ["camera.turn=9"], ["--threads", str(count)])
        stage = next(stage for stage in report["stages"] if stage["name"] == "raster")
        return stage["seconds"] / stage["runs"]

    pairs = [(raster(1), raster(2)) for _ in range(options.rounds)]
    ratio = statistics.median(one / two for one, two in pairs)
    row("bench-10k, raster stage on two threads", "1.8x", f"{ratio:.2f}x", ratio >= 1.8)


def film(program, _):
    report, wall = program.render(os.path.join(HERE, "year.toml"))
    row("year.toml, 365 frames", "60 s", f"{wall:.0f} s, {program.peak:.0f} MB", wall <= 60)
    for stage in report["stages"]:
        row(f"    of which {stage['name']}", "", f"{stage['seconds']:.1f} s")


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("out")
    parser.add_argument("--program", default="target/release/leafseason")
    parser.add_argument("--rivals")
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", nargs="*", default=["frames", "detail", "cold", "memory", "threads"])
    options = parser.parse_args()
    os.makedirs(options.out, exist_ok=True)
    program = Program(options.program, options.out)
    if options.rivals:
        scenes(program, options)
    for name in options.only:
        {one.__name__: one for one in (frames, detail, cold, memory, threads, film, scenes)}[name](program, options)
    print("\n| what | asked | found | met |\n| --- | --- | --- | --- |")
    for line in rows:
        print("| " + " | ".join(line) + " |")


main()
