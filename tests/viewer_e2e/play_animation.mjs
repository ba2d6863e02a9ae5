// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Makes a short animation of Play: one person goes to a seat and sits, others are about, insects crawl on the walls.
//   PANOPTIC_PROGRAM=build/release/panoptic PANOPTIC_WORK=/tmp node tests/viewer_e2e/play_animation.mjs MAP OUT.webp EYE TARGET
// EYE and TARGET are X,Y,Z in the figures' frame (Y is up): where the camera is and what it looks at.
import { writeFileSync } from 'node:fs';
import { launch, Viewer } from './browser.mjs';
import { Program } from './program.mjs';
import { animation } from './webp.mjs';

const kSize = { width: 640, height: 500 };
const kFrames = 60;
const kFrame_ms = 140;
const kQuality = 0.45;
const kMostBytes = 1e6;

const [map, out, eye, target] = process.argv.slice(2);
const place = (text) => text.split(',').map(Number);
if (!target || [...place(eye), ...place(target)].some(Number.isNaN)) {
  console.error('usage: play_animation.mjs MAP OUT.webp EYE TARGET; EYE and TARGET are X,Y,Z');
  process.exit(2);
}

// The seat that takes the longest way to reach, and somebody on the way to it.
async function begin(page) {
  await page.evaluate(([from, at]) => {
    const play = globalThis.panoptic_play;
    play.clear();
    for (let i = 0; i < 3; ++i) play.add_person();
    for (let i = 0; i < 3; ++i) play.add_insect();
    const [{ actor }, ...others] = play.crew.people;
    play.crew.places.seats.find((seat) => actor.sit(seat));
    others.forEach(({ actor: other }, i) => play.crew.places.seats.slice(i + 1).find((seat) => play.crew.is_free(seat) && other.sit(seat)));
    play.look(from, at);
  }, [place(eye), place(target)]);
  await page.keyboard.press('p');  // without the camera's path
  await page.waitForTimeout(2000);
}

const picture = (page) => page.evaluate(([passed_s, quality]) => {
  const play = globalThis.panoptic_play;
  play.advance(passed_s);
  play.picture_now();
  return document.querySelector('#surface canvas, canvas#surface').toDataURL('image/webp', quality).split(',')[1];
}, [kFrame_ms / 1000, kQuality]);

const browser = await launch();
const program = new Program(['play', map, '--port', '0']);
try {
  const viewer = await Viewer.open(browser, await program.url(), { viewport: kSize });
  await viewer.page.waitForFunction(() => globalThis.panoptic_play?.active);
  await begin(viewer.page);
  const pictures = [];
  for (let i = 0; i < kFrames; ++i) pictures.push(Buffer.from(await picture(viewer.page), 'base64'));
  const shown = await viewer.page.evaluate(() => { const { width, height } = document.querySelector('#surface canvas, canvas#surface'); return { width, height }; });
  const file = animation(pictures, { ...shown, frame_ms: kFrame_ms });
  if (file.length > kMostBytes) console.error(`${out} has ${file.length} bytes: choose a closer view`);
  writeFileSync(out, file);
  console.log(`${out}: ${pictures.length} pictures of ${shown.width} x ${shown.height}, ${file.length} bytes`);
  await viewer.close();
} finally {
  await browser.close();
  await program.stop();
}
