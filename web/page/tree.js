/**
 * The assembly as nested lists: a checkbox per node for what is drawn, and a button that opens its children. Children
 * are put on the page when they are opened, a few hundred at a time: assemblies may have a hundred thousand instances.
 */

import { element } from "./text.js";

/** Children that are put on the page at once. */
const CHUNK = 200;

/**
 * @typedef {{
 *   name: string,
 *   faces: number,
 *   instance?: number,
 *   children: TreeNode[],
 * }} TreeNode A node as the worker tells it. Leaves have the instance that is drawn.
 * @typedef {{ node: TreeNode, parent: Branch | null, children: Branch[], box: HTMLInputElement | null,
 *   row: HTMLElement | null, open: (() => void) | null, shown: boolean }} Branch
 */

export class Tree {
  /** @type {Branch[]} */ #roots = [];
  /** @type {Map<number, Branch>} */ #leaves = new Map();
  /** Puts more children into the list of a branch, or of the tree. @type {Map<Branch | null, () => void>} */
  #more = new Map();
  /** @type {HTMLElement | null} */ #picked = null;

  /**
   * @param {HTMLElement} list
   * @param {(instances: number[], visible: boolean) => void} show Called when a checkbox changes.
   */
  constructor(list, show) {
    this.list = list;
    this.show = show;
  }

  /** Replaces the tree. @param {TreeNode[]} roots */
  fill(roots) {
    this.#leaves.clear();
    this.#more.clear();
    this.#picked = null;
    this.#roots = roots.map((node) => this.#branch(node, null));
    this.list.replaceChildren();
    this.#put(this.list, this.#roots, 0);
    // A single root says little: its children are what one looks for.
    if (this.#roots.length === 1) this.#roots[0].open?.();
  }

  /** @param {TreeNode} node @param {Branch | null} parent @returns {Branch} */
  #branch(node, parent) {
    /** @type {Branch} */
    const branch = { node, parent, children: [], box: null, row: null, open: null, shown: true };
    branch.children = node.children.map((child) => this.#branch(child, branch));
    if (node.instance !== undefined) this.#leaves.set(node.instance, branch);
    return branch;
  }

  /**
   * Puts children from `first` on into a list.
   * @param {HTMLElement} list
   * @param {Branch[]} branches
   * @param {number} first
   */
  #put(list, branches, first) {
    for (const branch of branches.slice(first, first + CHUNK)) list.append(this.#item(branch));
    const left = branches.length - first - CHUNK;
    const parent = branches[0]?.parent ?? null;
    this.#more.delete(parent);
    if (left > 0) {
      const more = element(
        "button",
        { type: "button", class: "small more" },
        `${Math.min(left, CHUNK)} more of ${left}`,
      );
      const item = element("li", {}, more);
      const next = () => {
        item.remove();
        this.#put(list, branches, first + CHUNK);
      };
      more.onclick = next;
      this.#more.set(parent, next);
      list.append(item);
    }
  }

  /** @param {Branch} branch @returns {HTMLElement} */
  #item(branch) {
    const { node, children } = branch;
    const title = node.name || (children.length ? "assembly" : "part");
    const box = element("input", { type: "checkbox" });
    box.onchange = () => this.show(this.#set(branch, box.checked), box.checked);
    branch.box = box;
    this.#mark(branch);
    const faces = element("span", { class: "count" }, String(node.faces));
    faces.title = "faces";
    const label = element("label", {}, box, element("span", { title }, title));
    const row = element("div", { class: "node" }, label, faces);
    branch.row = row;
    const item = element("li", {}, row);
    if (children.length === 0) {
      row.prepend(element("span", { class: "twist" }));
      return item;
    }
    const twist = element(
      "button",
      { type: "button", class: "twist", "aria-expanded": "false", "aria-label": `Parts of ${title}` },
      "▸",
    );
    const list = element("ul", { hidden: "" });
    const open = (/** @type {boolean} */ wanted) => {
      if (wanted && list.childElementCount === 0) this.#put(list, children, 0);
      list.hidden = !wanted;
      twist.setAttribute("aria-expanded", String(wanted));
      twist.textContent = wanted ? "▾" : "▸";
    };
    twist.onclick = () => open(list.hidden);
    branch.open = () => open(true);
    row.prepend(twist);
    item.append(list);
    return item;
  }

  /** Shows or hides what is below a branch. @param {Branch} branch @param {boolean} visible @returns {number[]} */
  #set(branch, visible) {
    /** @type {number[]} */
    const instances = [];
    const visit = (/** @type {Branch} */ at) => {
      at.shown = visible;
      if (at.node.instance !== undefined) instances.push(at.node.instance);
      at.children.forEach(visit);
      this.#mark(at);
    };
    visit(branch);
    for (let at = branch.parent; at; at = at.parent) {
      at.shown = at.children.some((child) => child.shown);
      this.#mark(at);
    }
    return instances;
  }

  /** Brings a checkbox up to date: half checked if some of the children are hidden. @param {Branch} branch */
  #mark(branch) {
    if (!branch.box) return;
    const hidden = (/** @type {Branch} */ at) => !at.shown || at.children.some(hidden);
    branch.box.checked = branch.shown;
    branch.box.indeterminate = branch.shown && branch.children.some(hidden);
  }

  /** Marks the node of an instance, and opens the nodes above it. @param {number | null} instance */
  pick(instance) {
    this.#picked?.classList.remove("picked");
    this.#picked = null;
    const leaf = instance === null ? undefined : this.#leaves.get(instance);
    if (!leaf) return;
    const path = [];
    for (let at = leaf.parent; at; at = at.parent) path.unshift(at);
    for (const branch of [...path, leaf]) {
      while (!branch.row && this.#more.has(branch.parent)) this.#more.get(branch.parent)?.();
      if (branch !== leaf) branch.open?.();
    }
    this.#picked = leaf.row;
    leaf.row?.classList.add("picked");
    // Scrolls the list alone, not the page.
    if (leaf.row)
      this.list.scrollTop += leaf.row.getBoundingClientRect().top - this.list.getBoundingClientRect().top - 60;
  }
}
