/** Numbers to words, and rows of words to the page. */

/** @param {number} number @returns {string} Digits in groups of three. */
export function thousands(number) {
  return Math.round(number)
    .toString()
    .replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** @param {number} count @returns {string} */
export function bytes(count) {
  if (count < 1e4) return `${count} B`;
  if (count < 1e7) return `${(count / 1e3).toFixed(1)} kB`;
  if (count < 1e10) return `${(count / 1e6).toFixed(1)} MB`;
  return `${(count / 1e9).toFixed(1)} GB`;
}

/** @param {number} time @returns {string} */
export function milliseconds(time) {
  return `${time.toFixed(time < 100 ? 2 : 0)} ms`;
}

/**
 * Replaces the rows of a list of names and values.
 * @param {HTMLElement} list A `dl`.
 * @param {Iterable<[string, string]>} rows
 */
export function fill(list, rows) {
  const items = [];
  for (const [name, value] of rows) {
    const [term, fact] = [document.createElement("dt"), document.createElement("dd")];
    term.textContent = name;
    fact.textContent = value;
    items.push(term, fact);
  }
  list.replaceChildren(...items);
}

/**
 * An element with a text and attributes.
 * @template {keyof HTMLElementTagNameMap} K
 * @param {K} tag
 * @param {Record<string, string>} [attributes]
 * @param {(Node | string)[]} children
 * @returns {HTMLElementTagNameMap[K]}
 */
export function element(tag, attributes = {}, ...children) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.append(...children);
  return made;
}
