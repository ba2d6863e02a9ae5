// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// The bar on top: what is shown, whether the server is there, how far the run is.
import { by_id, set_text } from './dom.js';
import { duration_text } from './timeline.js';

const kStates = {
  connecting: 'Connecting', live: 'Live', finished: 'Finished', reconnecting: 'Reconnecting', refused: 'Token needed',
};
const kMessages = {
  connecting: 'Connecting to the server …',
  refused: 'The server wants a token: open the address that it printed, which ends in ?token=…',
};

export class Status {
  #state = 'connecting';
  #has_surface = false;

  set_scene(scene) {
    set_text(by_id('title'), scene.title);
    set_text(by_id('subtitle'), scene.dataset);
    by_id('subtitle').title = scene.dataset;
    document.title = `${scene.title} – PanopticFusion`;
    this.#has_surface = false;
    this.#show_message();
  }

  set_connection(state) {
    this.#state = state;
    const pill = by_id('connection');
    pill.dataset.state = state;
    set_text(pill, kStates[state]);
    this.#show_message();
  }

  set_run(run) {
    const pill = by_id('connection');
    pill.title = run.stopped_by ? `Stopped: ${run.stopped_by}` : '';
    if (run.finished && run.stopped_by) set_text(pill, 'Stopped');
    const bar = by_id('progress');
    const known = run.frames_total > 0;
    const share = known ? Math.min(1, run.frames_done / run.frames_total) : 0;
    bar.hidden = !known;
    bar.setAttribute('aria-valuemax', `${run.frames_total}`);
    bar.setAttribute('aria-valuenow', `${run.frames_done}`);
    bar.style.setProperty('--share', share.toFixed(4));
    const frames = known ? `${run.frames_done.toLocaleString('en')} / ${run.frames_total.toLocaleString('en')}` : `${run.frames_done.toLocaleString('en')} frames`;
    set_text(by_id('progress-text'), run.elapsed_s > 0 ? `${frames} · ${duration_text(run.elapsed_s)}` : frames);
  }

  set_counts({ chunks, triangles, waiting }) {
    this.#has_surface = triangles > 0;
    const text = `${triangles.toLocaleString('en')} triangles · ${chunks.toLocaleString('en')} chunks`;
    set_text(by_id('counts'), waiting > 0 ? `${text} · ${waiting} to come` : text);
    this.#show_message();
  }

  #show_message() {
    const waiting = this.#state === 'live' ? 'Waiting for the first surface …' : this.#state === 'finished' ? 'This map has no surface.' : kMessages.connecting;
    const text = this.#has_surface ? '' : (kMessages[this.#state] ?? waiting);
    set_text(by_id('message'), text);
  }
}

// A line at the lower edge that goes away by itself, or at once for the next one; '' is none.
export function notify(text) {
  const notice = by_id('notice');
  notice.textContent = text;
  notice.hidden = text === '';
  clearTimeout(notify.timer);
  notify.timer = setTimeout(() => { notice.hidden = true; }, 4000);
}
