# SPDX-License-Identifier: Apache-2.0
"""A scene made in code, a server of it, and a plain file server, for the tests of the page in browsers."""
import functools
import http.server
import json
import math
import os
import random
import struct
import subprocess
import threading

from PIL import ImageChops


def _brightest(picture):
    """The largest of the three channels of each pixel, as a grey picture."""
    red, green, blue = picture.split()
    return ImageChops.lighter(red, ImageChops.lighter(green, blue))


def different(a, b, step=8):
    """Pixels of two pictures that differ by more than `step` in a channel."""
    return sum(_brightest(ImageChops.difference(a, b)).histogram()[step + 1:])


def lit(picture):
    """Pixels that are not dark."""
    return sum(_brightest(picture).histogram()[41:])


def soft_box(picture):
    """The count and the centre (x, y) in pixels of the soft box of write_scene: what is red."""
    red, _, blue = picture.split()
    mask = ImageChops.multiply(red.point(lambda v: 255 * (v > 90)),
                               ImageChops.subtract(red, ImageChops.add(blue, blue)).point(lambda v: 255 * (v > 0)))
    found = [i for i, value in enumerate(mask.getdata()) if value]
    width = picture.width
    return len(found), tuple(sum(part) / max(1, len(found)) for part in ([i % width for i in found], [i // width for i in found]))


def write_box(file, colour, count=1500, half=0.5):
    """A box of flat kernels on its faces, as a .ply of 3DGS tools (y down); few, because a software renderer draws them."""
    random.seed(7)
    names = ['x', 'y', 'z', 'f_dc_0', 'f_dc_1', 'f_dc_2', 'opacity', 'scale_0', 'scale_1', 'scale_2', 'rot_0', 'rot_1', 'rot_2', 'rot_3']
    with open(file, 'wb') as out:
        out.write(('ply\nformat binary_little_endian 1.0\nelement vertex %d\n' % count +
                   ''.join(f'property float {name}\n' for name in names) + 'end_header\n').encode())
        for i in range(count):
            axis, side = i % 3, half if i // 3 % 2 else -half
            at = [random.uniform(-half, half) for _ in range(3)]
            at[axis] = side
            flat = [math.log(0.05)] * 3
            flat[axis] = math.log(0.005)
            shade = [(c * (0.7 + 0.15 * axis) - 0.5) / 0.28209479 for c in colour]
            out.write(struct.pack('<14f', *at, *shade, 4.0, *flat, 1, 0, 0, 0))


def write_scene(folder):
    """An elastic box that falls onto a floor next to a rigid one. The floor is a mesh, which is not drawn."""
    with open(os.path.join(folder, 'floor.obj'), 'w') as out:
        out.write('v -9 0 -9\nv -9 0 9\nv 9 0 9\nv 9 0 -9\nf 1 2 3\nf 1 3 4\n')
    write_box(os.path.join(folder, 'soft.ply'), (0.9, 0.3, 0.2))
    write_box(os.path.join(folder, 'hard.ply'), (0.2, 0.4, 0.9))
    scene = {
        'rate_hz': 90, 'environment': {'colliders': [{'mesh': 'floor.obj'}]},
        'objects': [
            {'name': 'soft', 'asset': 'soft.ply', 'scale': 0.3, 'label': 'foam block', 'pose': {'position_m': [-0.25, 0.4, 0]}},
            {'name': 'hard', 'asset': 'hard.ply', 'scale': 0.3, 'label': 'wooden block', 'pose': {'position_m': [0.25, 0.16, 0]}}]}
    file = os.path.join(folder, 'boxes.scene.json')
    with open(file, 'w') as out:
        json.dump(scene, out)
    return file


class Server:
    """livegs-server on a port of its own."""

    def __init__(self, program, scene, *arguments, port=0):
        self.process = subprocess.Popen([program, scene, '--listen', f'127.0.0.1:{port}', '--offline', '--print-port', *arguments],
                                        stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        line = self.process.stdout.readline().strip()
        if not line:
            raise SystemExit('served: livegs-server ended before it was ready')
        self.port = int(line)

    def stop(self, kill=False):
        if kill:
            self.process.kill()
        else:
            self.process.terminate()
        self.process.wait(60)
        self.process.stdout.close()


class Sidecar:
    """The sidecar of an Agones fleet for servers that start within this context; `annotations` of its GameServer."""

    def __init__(self, name):
        self.annotations, self.calls = {}, []
        outer = self

        class Handler(http.server.BaseHTTPRequestHandler):
            def answer(self):
                self.rfile.read(int(self.headers.get('content-length', 0)))
                outer.calls.append(f'{self.command} {self.path}')
                text = json.dumps({'object_meta': {'name': name, 'annotations': outer.annotations}, 'status': {'state': 'Ready'}}).encode()
                self.send_response(200)
                self.send_header('content-length', str(len(text)))
                self.end_headers()
                self.wfile.write(text)

            do_GET = do_POST = do_PUT = do_PATCH = answer

            def log_message(self, *_):
                pass

        self.server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), Handler)
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def __enter__(self):
        os.environ['AGONES_SDK_HTTP_PORT'] = str(self.server.server_address[1])
        return self

    def __exit__(self, *_):
        del os.environ['AGONES_SDK_HTTP_PORT']
        self.server.shutdown()
        self.server.server_close()


class Site:
    """A folder behind a plain file server, a site of its own. `cuts`: the first transfer of each asset ends in its middle."""

    def __init__(self, folder, cuts=False):
        handler = functools.partial(QuietHandler, cut=set() if cuts else None, directory=folder)
        self.server = http.server.ThreadingHTTPServer(('127.0.0.1', 0), handler)
        self.origin = f'http://127.0.0.1:{self.server.server_address[1]}'
        threading.Thread(target=self.server.serve_forever, daemon=True).start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.shutdown()
        self.server.server_close()


class QuietHandler(http.server.SimpleHTTPRequestHandler):
    def __init__(self, *arguments, cut, **named):
        self.cut = cut  # paths whose transfer was cut; None: nothing is cut
        super().__init__(*arguments, **named)

    def do_GET(self):
        file = self.translate_path(self.path)
        if self.cut is None or file in self.cut or os.path.basename(os.path.dirname(file)) != 'assets' or not os.path.exists(file):
            return super().do_GET()
        self.cut.add(file)
        with open(file, 'rb') as source:
            data = source.read()
        self.send_response(200)
        self.send_header('content-length', str(len(data)))
        self.end_headers()
        self.wfile.write(data[:len(data) // 2])
        self.close_connection = True

    def log_message(self, *_):
        pass
