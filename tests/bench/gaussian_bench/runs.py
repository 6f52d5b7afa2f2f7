# SPDX-License-Identifier: Apache-2.0
"""Runs a scene by `livegs simulate` and reads its tables while they are written.

The tables go through pipes, because those of the beams have millions of rows; only the rows that the scorer needs are
kept.
"""
import json
import os
import subprocess
import threading
import time
from pathlib import Path

PARTICLE_COLUMNS = "frame,time_s,object,particle_id,x,y,z,vx,vy,vz,mass_kg,F00,F01,F02,F10,F11,F12,F20,F21,F22"
KERNEL_COLUMNS = "frame,time_s,object,kernel_id,x,y,z,sxx,sxy,sxz,syy,syz,szz,F00,F01,F02,F10,F11,F12,F20,F21,F22"


class Failure(Exception):
    """A reason in the form "thing: problem; remedy"."""


class Table:
    """Rows of one table: frame -> list of (object, id, numbers), for the rows that `wanted(frame, id)` accepts."""

    def __init__(self, header, wanted, first, last):
        self.header, self.wanted = header, wanted
        self.first, self.last = first, last  # columns that are kept
        self.frames, self.times_s = {}, {}

    def read(self, path):
        with open(path, "rb") as file:
            header = file.readline().decode().strip()
            if header and header != self.header:
                raise Failure(f"{Path(path).name}: unknown columns; adapt runs.py to this program")
            rows, frame, before = None, -1, None
            for line in file:
                number, time_s, name, index, rest = line.split(b",", 4)
                if number != before:
                    before, frame = number, int(number)
                    rows = self.frames.setdefault(frame, [])
                    self.times_s[frame] = float(time_s)
                if self.wanted(frame, int(index)):
                    numbers = rest.split(b",")[self.first : self.last]
                    rows.append((name, int(index), [float(v) for v in numbers]))


class Run:
    """What one simulation left: its tables, its pictures' folder and its summary."""

    def __init__(self, case, program, folder, wanted, kernels_wanted=None):
        self.particles = Table(PARTICLE_COLUMNS, wanted, 0, 16)
        self.kernels = Table(KERNEL_COLUMNS, kernels_wanted, 3, 18) if case.kernels else None
        scene = case.write(folder)
        self.folder = folder / "out"
        self.folder.mkdir(exist_ok=True)
        tables = {"particles.csv": self.particles}
        command = [program, "simulate", scene, "-o", self.folder, "--seconds", repr(case.seconds), "--no-sleep"]
        command += ["--particles"]
        if self.kernels:
            tables["kernels.csv"] = self.kernels
            command += ["--kernels"]
        if case.camera:
            last = round(case.seconds * case.rate_hz)
            command += ["--render", folder / "camera.json", "--every", str(last)]
        began = time.monotonic()
        self._start(command, tables)
        self.wall_s = time.monotonic() - began
        self.summary = json.loads((self.folder / "summary.json").read_text())

    def _start(self, command, tables):
        failures = []
        for name in tables:
            (self.folder / name).unlink(missing_ok=True)
            os.mkfifo(self.folder / name)

        def read(name, table):
            try:
                table.read(self.folder / name)
            except Exception as error:  # reported by the main thread
                failures.append(error)

        readers = [threading.Thread(target=read, args=each) for each in tables.items()]
        for reader in readers:
            reader.start()
        try:
            process = subprocess.Popen(
                [str(word) for word in command], stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True
            )
            _, told = process.communicate()
            code = process.returncode
        except OSError as error:
            code, told = 1, f"{command[0]}: {error.strerror}; build the target livegs or give --program"
        for reader, name in zip(readers, tables):
            while reader.is_alive():  # a program that failed did not open its tables
                try:
                    os.close(os.open(self.folder / name, os.O_WRONLY | os.O_NONBLOCK))
                except OSError:
                    pass
                reader.join(0.05)
            (self.folder / name).unlink()
        if code:
            lines = [line for line in told.splitlines() if line.strip()]
            raise Failure(lines[-1] if lines else f"{command[0]}: exit code {code}; see its log")
        for failure in failures:
            raise failure
