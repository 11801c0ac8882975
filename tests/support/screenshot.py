"""Drive Blender's window on a virtual display, and photograph it.

    PT_BLENDER=$(scripts/blender) python tests/support/screenshot.py steps.py picture.png [ARGUMENTS]

`steps.py` runs inside Blender and defines `steps()`, a generator that is advanced between redraws:

    yield 1.0                                              wait a second
    yield lambda: not bpy.app.is_job_running("RENDER")     wait until true
    yield "shot"  or  yield "shot:panel"                   picture.png, picture-panel.png
    yield "move:640,400", "click:640,400", "key:Escape"    the mouse and the keyboard

The picture is read from the X server's own memory, so it shows what a person would see.
"""

from __future__ import annotations

import os
import struct
import subprocess
import sys
import tempfile
import time
import zlib
from contextlib import ExitStack, suppress
from pathlib import Path

WIDTH, HEIGHT = 1280, 800
# xdotool presses Alt along with a function key unless it gets the key's number
KEYCODES = {f"F{i}": str(66 + i if i < 11 else 84 + i) for i in range(1, 13)}

DRIVER = r"""
import bpy, os, sys, traceback
tmp, script = os.environ["PT_SHOT_TMP"], os.environ["PT_SHOT_STEPS"]
bpy.context.preferences.view.show_splash = False
sys.stdout.reconfigure(line_buffering=True)
state = {"number": 0, "wait": None, "steps": None}

def tell(name, text):
    with open(os.path.join(tmp, name + ".part"), "w") as file:
        file.write(text)
    os.replace(os.path.join(tmp, name + ".part"), os.path.join(tmp, name))

def leave():
    with bpy.context.temp_override(window=bpy.context.window_manager.windows[0]):
        bpy.ops.wm.quit_blender()

def tick():
    try:
        wait = state["wait"]
        if wait is not None and not (wait() if callable(wait) else os.path.exists(wait)):
            return 0.05
        state["wait"] = None
        if state["steps"] is None:
            space = {"__name__": "steps", "__file__": script}
            exec(compile(open(script).read(), script, "exec"), space)
            state["steps"] = space["steps"]()
        what = next(state["steps"], "done")
        if isinstance(what, (int, float)):
            return float(what)
        if what == "done":
            tell("done", "ok")
            bpy.app.timers.register(leave, first_interval=0.1, persistent=True)
            return None
        if isinstance(what, str):
            state["number"] += 1
            tell("ask%d" % state["number"], what)
            what = os.path.join(tmp, "answer%d" % state["number"])
        state["wait"] = what
        return 0.05
    except BaseException:
        traceback.print_exc()
        tell("done", "error")
        return None

bpy.app.timers.register(tick, first_interval=0.5, persistent=True)
"""


class WindowError(RuntimeError):
    """Blender or the display failed; the message has what Blender printed."""


def photograph(blender, steps, picture, arguments=(), resources=None, timeout=120.0) -> str:
    """Run `steps` in Blender's window; what Blender printed.

    Parameters
    ----------
    blender : str
        The command of a real Blender. Xvfb and xdotool are run where it is: by `run-inside` beside it,
        if `scripts/blender` has made one, else on this machine.
    steps : str
        A file that defines `steps()`.
    picture : path
        Where the photograph goes.
    resources : path, optional
        Blender's user folder; without one it is an empty one with factory settings.
    """
    with ExitStack() as stack:
        tmp = stack.enter_context(tempfile.TemporaryDirectory(prefix="pt-shot-"))
        run = beside(blender)
        log = stack.enter_context(open(Path(tmp, "log"), "w+", errors="replace"))
        display = start_display(stack, run, tmp, log)
        environment = {
            **os.environ,
            "DISPLAY": display,
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "XDG_RUNTIME_DIR": tmp,
            "TMPDIR": tmp,
            "BLENDER_USER_RESOURCES": str(resources or Path(tmp, "user")),
            "PT_SHOT_TMP": tmp,
            "PT_SHOT_STEPS": str(Path(steps).resolve()),
        }
        environment.pop("WAYLAND_DISPLAY", None)
        Path(environment["BLENDER_USER_RESOURCES"]).mkdir(parents=True, exist_ok=True)
        Path(tmp, "driver.py").write_text(DRIVER)
        command = [blender, "--gpu-backend", "opengl", "--window-geometry", "0", "0", str(WIDTH), str(HEIGHT)]
        command += [] if resources else ["--factory-startup"]
        command += [*map(str, arguments), "-P", str(Path(tmp, "driver.py"))]
        window = subprocess.Popen(command, env=environment, stdout=log, stderr=subprocess.STDOUT)
        stack.callback(end, window)
        try:
            answer(window, tmp, Path(picture), run, environment, time.monotonic() + timeout)
        except WindowError as error:
            raise WindowError(f"{error}\n{Path(tmp, 'log').read_text(errors='replace')[-6000:]}") from None
        return Path(tmp, "log").read_text(errors="replace")


def beside(blender: str) -> list[str]:
    """How to run other programs where this Blender is."""
    path = Path(blender)
    for name in ("run-inside", path.name.replace("blender", "run", 1)):
        if name != path.name and path.with_name(name).is_file():
            return [str(path.with_name(name))]
    return []


def start_display(stack: ExitStack, run, tmp, log) -> str:
    """Start Xvfb with its screen in a file; the display's name."""
    reading, writing = os.pipe()
    screen = ["-screen", "0", f"{WIDTH}x{HEIGHT}x24", "-fbdir", tmp, "-nolisten", "tcp", "-noreset"]
    command = [*run, "Xvfb", "-displayfd", str(writing), *screen]
    stack.callback(end, subprocess.Popen(command, stdout=log, stderr=log, pass_fds=[writing]))
    os.close(writing)
    with os.fdopen(reading) as pipe:
        number = pipe.readline().strip()
    if not number:
        raise WindowError("Xvfb did not start")
    return f":{number}"


def answer(window, tmp, picture: Path, run, environment, until) -> None:
    """Do what the steps ask for until they are done and Blender has ended."""
    number = 1
    while not Path(tmp, "done").exists():
        ask = Path(tmp, f"ask{number}")
        if ask.exists():
            what, _, argument = ask.read_text().partition(":")
            if what == "shot":
                name = f"{picture.stem}-{argument}{picture.suffix}" if argument else picture.name
                write_png(picture.with_name(name), settled(Path(tmp, "Xvfb_screen0")))
            elif what == "key":
                press(run, environment, "key", "+".join(KEYCODES.get(k, k) for k in argument.split("+")))
            else:
                click = ["sleep", "0.2", "click", "1"] if what == "click" else []
                press(run, environment, "mousemove", *argument.split(","), *click)
            Path(tmp, f"answer{number}").touch()
            number += 1
        if window.poll() is not None:
            raise WindowError(f"Blender ended with code {window.returncode}")
        if time.monotonic() > until:
            raise WindowError("the time is up")
        time.sleep(0.05)
    if Path(tmp, "done").read_text() != "ok":
        raise WindowError("a step failed")
    if code := window.wait(20):
        raise WindowError(f"Blender ended with code {code}")


def press(run, environment, *words) -> None:
    """Mouse and keyboard."""
    subprocess.run([*run, "xdotool", *words], env=environment, check=True, timeout=30)


def settled(framebuffer: Path, quiet=0.4, most=3.0):
    """The screen when it has not changed for a while, or after a few seconds if it goes on changing."""
    begun = since = time.monotonic()
    last = None
    while True:
        with suppress(OSError, struct.error):
            now = read_screen(framebuffer)
            if now != last:
                last, since = now, time.monotonic()
        if last and (time.monotonic() - since >= quiet or time.monotonic() - begun > most):
            return last
        time.sleep(0.1)


def read_screen(path: Path) -> tuple[int, int, bytes]:
    """Width, height and RGB bytes of Xvfb's screen, a file in X's window dump format."""
    data = path.read_bytes()
    head = struct.unpack(">25I", data[:100])
    start, width, height, order, stride = head[0] + 12 * head[19], head[4], head[5], head[7], head[12]
    r, g, b = (2, 1, 0) if order == 0 else (1, 2, 3)
    rgb = bytearray(3 * width * height)
    for y in range(height):
        line = data[start + y * stride : start + y * stride + 4 * width]
        row = slice(3 * width * y, 3 * width * (y + 1))
        pixels = bytearray(3 * width)
        pixels[0::3], pixels[1::3], pixels[2::3] = line[r::4], line[g::4], line[b::4]
        rgb[row] = pixels
    return width, height, bytes(rgb)


def write_png(path: Path, screen: tuple[int, int, bytes]) -> None:
    """8-bit RGB."""
    width, height, rgb = screen

    def chunk(kind, body):
        return struct.pack(">I", len(body)) + kind + body + struct.pack(">I", zlib.crc32(kind + body))

    rows = b"".join(b"\0" + rgb[3 * width * y : 3 * width * (y + 1)] for y in range(height))
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    body = chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(rows, 6)) + chunk(b"IEND", b"")
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + body)


def end(process: subprocess.Popen) -> None:
    """End a process that this file has started."""
    if process.poll() is None:
        process.terminate()
        try:
            process.wait(3)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


if __name__ == "__main__":
    print(photograph(os.environ["PT_BLENDER"], sys.argv[1], sys.argv[2], sys.argv[3:]))
