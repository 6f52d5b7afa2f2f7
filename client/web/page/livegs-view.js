// SPDX-License-Identifier: Apache-2.0
// <livegs-view src="https://server:9780/" token="TOKEN"></livegs-view>: a live scene in a page of another site, to watch only.
// The server must allow the site (livegs-server --allow-origin); the token should have the scope view. The scene runs in a
// frame of the server's origin, so the other page gets no access to it; the token is in the fragment, which is not sent.
customElements.define('livegs-view', class extends HTMLElement {
  static observedAttributes = ['src', 'token'];
  connectedCallback() {
    this.style.display ||= 'inline-block';
    this.open();
  }
  attributeChangedCallback() { if (this.isConnected) this.open(); }
  // In a new frame, because a change of the fragment alone does not load the page again.
  open() {
    const src = this.getAttribute('src'), token = this.getAttribute('token');
    if (!src) return this.replaceChildren();
    const address = new URL(src, document.baseURI), frame = document.createElement('iframe');
    if (!/^https?:$/.test(address.protocol)) return this.replaceChildren();
    address.hash = new URLSearchParams({ view: '', ...(token ? { token } : {}) });
    Object.assign(frame, { src: address.href, allow: 'xr-spatial-tracking; fullscreen', title: this.title || 'LiveGS scene' });
    Object.assign(frame.style, { border: '0', width: '100%', height: '100%', display: 'block' });
    this.replaceChildren(frame);
  }
});
