// SPDX-FileCopyrightText: 2026 The PanopticFusion Authors
// SPDX-License-Identifier: Apache-2.0
//
// Building and finding elements. Text always goes in as text, never as markup: names come from outside.

export function by_id(id) {
  const found = document.getElementById(id);
  if (!found) throw new Error(`index.html has no element #${id}`);
  return found;
}

// element('button', {class: 'x', 'aria-label': 'y', text: 'z', on: {click: f}}, child, ...)
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === 'text') made.textContent = value;
    else if (name === 'on') for (const [event, listener] of Object.entries(value)) made.addEventListener(event, listener);
    else if (value === true) made.setAttribute(name, '');
    else if (value !== false && value !== undefined && value !== null) made.setAttribute(name, value);
  }
  made.append(...children.filter((child) => child !== null && child !== undefined));
  return made;
}

// Writing the same text again would make the browser lay out anew.
export function set_text(target, text) {
  if (target.textContent !== text) target.textContent = text;
}

export function css_color([red, green, blue]) {
  return `rgb(${red} ${green} ${blue})`;
}
