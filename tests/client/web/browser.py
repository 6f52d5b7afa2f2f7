# SPDX-License-Identifier: Apache-2.0
"""A headless Chromium that a test drives over the DevTools protocol (Debian packages chromium, python3-pil,
python3-websocket)."""
import base64
import io
import json
import os
import shutil
import subprocess
import tempfile
import time

from PIL import Image
import websocket


class Browser:
    """One page. Use as a context manager; the browser ends with it."""

    def __init__(self, width=640, height=480, arguments=()):
        self.profile = tempfile.mkdtemp(prefix='livegs_browser_')
        program = shutil.which('chromium') or shutil.which('chromium-browser')
        if not program:
            raise SystemExit('browser: no chromium; run deploy/install-dependencies tests')
        self.process = subprocess.Popen(
            [program, '--headless=new', '--no-sandbox', '--disable-dev-shm-usage', '--no-first-run', '--hide-scrollbars',
             '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--remote-debugging-port=0',
             '--remote-allow-origins=*', f'--window-size={width},{height}', f'--user-data-dir={self.profile}',
             *arguments, 'about:blank'],
            stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
        self.console = []    # lines of errors and exceptions
        self.requests = []   # addresses
        self.received = 0    # bytes over the wire, without those of WebSockets
        self.width, self.height = width, height
        for line in self.process.stderr:
            if 'DevTools listening on' in line:
                address = line.split()[-1]
                break
        else:
            raise SystemExit('browser: chromium ended before it was ready')
        self.socket = websocket.create_connection(address, suppress_origin=True, timeout=60)
        self.next_id = 0
        self.session = None
        target = self.ask('Target.createTarget', url='about:blank')['targetId']
        self.session = self.ask('Target.attachToTarget', targetId=target, flatten=True)['sessionId']
        for domain in ('Page', 'Runtime', 'Network', 'Log'):
            self.ask(domain + '.enable')
        self.ask('Emulation.setDeviceMetricsOverride', width=width, height=height, deviceScaleFactor=1, mobile=False)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.socket.close()
        self.process.terminate()
        try:
            self.process.wait(20)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        shutil.rmtree(self.profile, ignore_errors=True)

    def ask(self, method, **parameters):
        self.next_id += 1
        wish = {'id': self.next_id, 'method': method, 'params': parameters}
        if self.session:
            wish['sessionId'] = self.session
        self.socket.send(json.dumps(wish))
        while True:
            message = json.loads(self.socket.recv())
            if message.get('id') == self.next_id:
                if 'error' in message:
                    raise RuntimeError(f"{method}: {message['error']['message']}")
                return message['result']
            self._hear(message)

    def _hear(self, message):
        method, given = message.get('method'), message.get('params', {})
        if method == 'Runtime.exceptionThrown':
            details = given['exceptionDetails']
            self.console.append(details.get('exception', {}).get('description') or details['text'])
        elif method == 'Runtime.consoleAPICalled' and given['type'] in ('error', 'assert'):
            self.console.append(' '.join(str(one.get('value', one.get('description'))) for one in given['args']))
        elif method == 'Log.entryAdded' and given['entry']['level'] == 'error':
            self.console.append(f"{given['entry']['text']} {given['entry'].get('url', '')}")
        elif method == 'Network.requestWillBeSent':
            self.requests.append(given['request']['url'])
        elif method == 'Network.loadingFinished':
            self.received += given['encodedDataLength']

    def open(self, address):
        self.ask('Page.navigate', url=address)

    def run(self, script):
        """The value of a JavaScript expression; promises are awaited."""
        result = self.ask('Runtime.evaluate', expression=script, awaitPromise=True, returnByValue=True)
        if 'exceptionDetails' in result:
            raise RuntimeError(f"{script}: {result['exceptionDetails']}")
        return result['result'].get('value')

    def wait(self, script, seconds=60):
        """Waits until an expression is true; returns its value, or raises TimeoutError."""
        until = time.monotonic() + seconds
        while time.monotonic() < until:
            value = self.run(script)
            if value:
                return value
            time.sleep(0.05)
        shown = self.run("`${location.href}: ${document.body?.innerText ?? ''}`")
        raise TimeoutError(f'{script} after {seconds} s; page {shown}; console: {self.console}')

    def mouse(self, kind, x, y, button='left', buttons=1, modifiers=0):
        self.ask('Input.dispatchMouseEvent', type='mouse' + kind, x=x, y=y, button=button, buttons=buttons,
                 clickCount=1, modifiers=modifiers)

    def drag(self, start, end, steps=10, button='left', buttons=1, modifiers=0, hold_s=0.0):
        self.mouse('Moved', *start, button='none', buttons=0, modifiers=modifiers)
        self.mouse('Pressed', *start, button=button, buttons=buttons, modifiers=modifiers)
        for i in range(1, steps + 1):
            at = [a + (b - a) * i / steps for a, b in zip(start, end)]
            self.mouse('Moved', *at, button=button, buttons=buttons, modifiers=modifiers)
            time.sleep(0.02)
        time.sleep(hold_s)
        self.mouse('Released', *end, button=button, buttons=0, modifiers=modifiers)

    def press(self, key, code=None):
        for kind in ('keyDown', 'keyUp'):
            self.ask('Input.dispatchKeyEvent', type=kind, key=key, code=code or f'Key{key.upper()}',
                     text=key if kind == 'keyDown' and len(key) == 1 else '')

    def picture(self, file=None):
        """The page as a PIL image; also written to `file`, a PNG."""
        until = time.monotonic() + 10
        while True:
            try:
                png = base64.b64decode(self.ask('Page.captureScreenshot', format='png')['data'])
                break
            except RuntimeError as error:  # the page is being replaced by the next one
                if 'Not attached to an active page' not in str(error) or time.monotonic() > until:
                    raise
                time.sleep(0.1)
        if file:
            os.makedirs(os.path.dirname(os.path.abspath(file)), exist_ok=True)
            with open(file, 'wb') as out:
                out.write(png)
        return Image.open(io.BytesIO(png)).convert('RGB')
