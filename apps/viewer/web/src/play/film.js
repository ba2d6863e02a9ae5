// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The recording's frames for the camera view: fetched one at a time, the newest wish first.
import { CameraView } from './camera_view.js';
import { fetch_frame, fetch_frames } from './play_data.js';

export class Film {
  #page;
  #panel;
  #view = null;
  #frames = null;
  #asked = 0;

  // panel: set_frames(count), go_to(place), place, say(text), mark(name, on).
  constructor(page, panel) {
    this.#page = page;
    this.#panel = panel;
  }

  get shown() {
    return this.#page.stage.instead !== null;
  }

  // The ray through a pixel of the canvas; null beside the picture.
  aim(x_px, y_px, width, height) {
    return this.#view.aim(x_px, y_px, width, height);
  }

  hide() {
    this.#page.stage.instead = null;
    this.#panel.mark('film', false);
    this.#page.stage.invalidate();
  }

  async show() {
    const { stage, surface, material } = this.#page;
    try {
      this.#frames ??= await fetch_frames();
    } catch (error) {
      return this.#panel.say(error.message);
    }
    this.#view ??= new CameraView(stage, surface, material.depth);
    this.#panel.set_frames(this.#frames.length);
    await this.#panel.go_to(this.#panel.place);
    if (!this.#view.frame) return null;
    stage.instead = (renderer, scene) => this.#view.draw(renderer, scene);
    this.#panel.mark('film', true);
    return stage.invalidate();
  }

  // Returns the frame's number, or null if another one is wanted by now, or it cannot be had.
  async go_to(place) {
    const asked = ++this.#asked;
    try {
      const frame = await fetch_frame(place);
      if (asked !== this.#asked) {
        frame.image.close();
        return null;
      }
      this.#view.show(frame);
      return frame.frame;
    } catch (error) {
      this.#panel.say(error.message);
      return null;
    }
  }

  async save() {
    const picture = await this.#view.picture();
    if (picture) this.#page.save_picture(picture, this.#view.frame.frame);
  }
}
