// SPDX-License-Identifier: Apache-2.0
// <livegs-view src="https://server:9780/" token="TOKEN"></livegs-view>: a live scene in a page of another site, to watch only.
// The server must allow the site (livegs-server --allow-origin); the token should have the scope view. The scene runs in a
// frame of the server's origin, so the other page gets no access to it; the token is in the fragment, which is not sent.
customElements.define('livegs-view', class extends HTMLElement {
  static observedAttributes = ['src', 'token'];
  connectedCallback() {
    this.style.display ||= 'inline-block';
    this.frame = document.createElement('iframe');
    Object.assign(this.frame, { allow: 'xr-spatial-tracking; fullscreen', title: this.title || 'LiveGS scene' });
    Object.assign(this.frame.style, { border: '0', width: '100%', height: '100%', display: 'block' });
    this.open();
    this.replaceChildren(this.frame);
  }
  attributeChangedCallback() { if (this.frame) this.open(); }
  open() {
    const address = new URL(this.getAttribute('src') ?? '', document.baseURI), token = this.getAttribute('token');
    address.hash = new URLSearchParams({ view: '', ...(token ? { token } : {}) });
    if (/^https?:$/.test(address.protocol)) this.frame.src = address.href;
  }
});
