// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The camera's view: the newest frame, or the newest frame with labels under its panoptic overlay. Pictures are swapped when
// the next one is complete, so that nothing flickers; while one is loading newer ones wait.
import { element, set_text } from './dom.js';

const kEvery_ms = 400;  // the server encodes a picture for every frame that somebody asks for

export class FramePanel {
  #images = new Map();  // name -> <img>
  #shown = {};
  #wanted = null;
  #loading = false;
  #caption;
  #picture;
  #empty;
  #slider;
  #choice;
  #labelled = true;
  #run = '';

  constructor(root) {
    for (const name of ['color', 'overlay']) this.#images.set(name, element('img', { class: name, alt: name === 'color' ? 'What the camera sees' : '', hidden: true }));
    const overlay = this.#images.get('overlay');
    const slider = element('input', { type: 'range', min: 0, max: 100, value: 55, 'aria-label': 'Opacity of the labels over the image',
      on: { input: () => { overlay.style.opacity = slider.value / 100; } } });
    overlay.style.opacity = slider.value / 100;
    this.#slider = element('label', { class: 'slider' }, element('span', { class: 'muted', text: 'Labels' }), slider);
    const choice = this.#choice = element('select', { 'aria-label': 'Which image', on: { change: () => { this.#labelled = choice.value === 'labelled'; this.#choose(); } } },
      element('option', { value: 'labelled', text: 'With labels' }), element('option', { value: 'newest', text: 'Newest' }));
    this.#caption = element('span', { class: 'muted tabular' });
    this.#empty = element('p', { class: 'empty', text: 'No image is kept.' });
    this.#picture = element('div', { class: 'picture' }, ...this.#images.values(), this.#empty);
    root.append(element('div', { class: 'card-head' }, element('h2', { text: 'Camera' }), this.#caption, choice), this.#picture,
      this.#slider);
  }

  reset(run) {
    this.#run = encodeURIComponent(run);
    this.#wanted = null;
    set_text(this.#caption, '');
    this.#shown = {};
    this.#show(false);
  }

  update(frame) {
    this.#wanted = frame;
    this.#choose();
  }

  async #choose() {
    if (this.#loading || !this.#wanted || this.#wanted.index < 0) return;
    const labelled = this.#labelled && this.#wanted.labelled_index >= 0;
    const index = labelled ? this.#wanted.labelled_index : this.#wanted.index;
    const key = `${labelled}${index}`;
    if (this.#shown.key === key) return;
    this.#loading = true;
    const run = this.#run;
    const query = `?frame=${index}&run=${run}`;
    const [color, overlay] = await Promise.all([loaded(`/api/${labelled ? 'labelled' : 'frame'}.jpg${query}`), labelled ? loaded(`/api/overlay.png${query}`) : null]);
    if (run === this.#run) {
      this.#shown = { key };
      this.#swap('color', color);
      this.#swap('overlay', overlay);
      this.#show(color !== null);
      set_text(this.#caption, color ? `frame ${index}` : '');
    }
    await new Promise((resolve) => setTimeout(resolve, kEvery_ms));
    this.#loading = false;
    this.#choose();
  }

  #swap(name, picture) {
    const image = this.#images.get(name);
    if (image.src) URL.revokeObjectURL(image.src);
    image.hidden = picture === null;
    if (name === 'overlay') this.#slider.hidden = picture === null;
    picture === null ? image.removeAttribute('src') : image.setAttribute('src', picture);
  }

  #show(something) {
    this.#empty.hidden = something;
    this.#choice.hidden = !something;
    this.#picture.classList.toggle('none', !something);
    if (!something) for (const name of this.#images.keys()) this.#swap(name, null);
  }
}

// Null where the server keeps no such picture; a missing one is normal and not an error on the page.
async function loaded(path) {
  try {
    const answer = await fetch(path);
    if (!answer.ok) return null;
    const address = URL.createObjectURL(await answer.blob());
    const image = new Image();
    image.src = address;
    await image.decode();
    return address;
  } catch {
    return null;
  }
}
