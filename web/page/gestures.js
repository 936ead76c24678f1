/**
 * Pointers, wheel and keys on the picture to camera movements. Positions are in pixels of the canvas.
 * One pointer turns, two move and zoom; a press that hardly moves is a pick.
 */

/** How far a pointer may move, in CSS pixels, for its press to be a pick. */
const CLICK = 5;

/**
 * @typedef {{
 *   press(x: number, y: number): void,
 *   orbit(dx: number, dy: number): void,
 *   pan(x0: number, y0: number, x1: number, y1: number): void,
 *   zoom(x: number, y: number, factor: number): void,
 *   pick(x: number, y: number): void,
 * }} Hands What gestures do. `press` says where turning and moving take hold.
 */

/**
 * Listens for pointers and the wheel.
 * @param {HTMLElement} element
 * @param {Hands} hands
 */
export function listen(element, hands) {
  /** @type {Map<number, { x: number, y: number }>} */
  const pointers = new Map();
  let moved = 0;
  let sliding = false;

  /** @param {{ clientX: number, clientY: number }} event */
  const place = (event) => {
    const box = element.getBoundingClientRect();
    return { x: (event.clientX - box.left) * devicePixelRatio, y: (event.clientY - box.top) * devicePixelRatio };
  };
  /** The middle of all pointers and their distance from it. */
  const grip = () => {
    const all = [...pointers.values()];
    const x = all.reduce((sum, at) => sum + at.x, 0) / all.length;
    const y = all.reduce((sum, at) => sum + at.y, 0) / all.length;
    return { x, y, reach: Math.hypot(all[0].x - x, all[0].y - y) };
  };

  element.addEventListener("pointerdown", (event) => {
    if (pointers.size === 2) return;
    element.setPointerCapture(event.pointerId);
    pointers.set(event.pointerId, place(event));
    sliding = event.button !== 0 || event.shiftKey;
    moved = pointers.size === 1 && event.button === 0 ? 0 : Infinity;
    const { x, y } = grip();
    hands.press(x, y);
  });

  element.addEventListener("pointermove", (event) => {
    const last = pointers.get(event.pointerId);
    if (!last) return;
    const old = grip();
    const now = place(event);
    moved += Math.hypot(now.x - last.x, now.y - last.y);
    pointers.set(event.pointerId, now);
    if (moved < CLICK * devicePixelRatio) return;
    if (pointers.size === 2) {
      const fresh = grip();
      hands.pan(old.x, old.y, fresh.x, fresh.y);
      if (old.reach > 1 && fresh.reach > 1) hands.zoom(fresh.x, fresh.y, old.reach / fresh.reach);
    } else if (sliding || event.shiftKey) {
      hands.pan(last.x, last.y, now.x, now.y);
    } else {
      hands.orbit(now.x - last.x, now.y - last.y);
    }
  });

  /** @param {PointerEvent} event */
  const release = (event) => {
    const at = pointers.get(event.pointerId);
    if (!at) return;
    pointers.delete(event.pointerId);
    if (event.type === "pointerup" && pointers.size === 0 && moved < CLICK * devicePixelRatio) hands.pick(at.x, at.y);
    if (pointers.size === 1) {
      // The finger that stays takes hold anew.
      moved = Infinity;
      const { x, y } = grip();
      hands.press(x, y);
    }
  };
  element.addEventListener("pointerup", release);
  element.addEventListener("pointercancel", release);
  element.addEventListener("contextmenu", (event) => event.preventDefault());

  element.addEventListener(
    "wheel",
    (event) => {
      event.preventDefault();
      const { x, y } = place(event);
      // Lines and pages as pixels; a pinch on a touchpad arrives as a wheel with ctrl, in smaller numbers.
      const unit = [1, 18, 400][event.deltaMode] * (event.ctrlKey ? 8 : 1);
      const turned = Math.max(-600, Math.min(600, event.deltaY * unit));
      hands.zoom(x, y, Math.exp(turned / 600));
    },
    { passive: false },
  );
}

/** Degrees that an arrow key turns, as a part of the picture's height: a drag over the height is half a turn. */
const STEP = 1 / 24;

/**
 * What a key on the picture does with the camera, or null if the key has no such meaning.
 * @param {KeyboardEvent} event
 * @param {[number, number]} size Width and height of the canvas.
 * @returns {((hands: Hands) => void) | null}
 */
export function movement(event, [width, height]) {
  const step = STEP * height;
  const [x, y] = [width / 2, height / 2];
  const arrows = { ArrowLeft: [-step, 0], ArrowRight: [step, 0], ArrowUp: [0, -step], ArrowDown: [0, step] };
  const arrow = arrows[/** @type {keyof typeof arrows} */ (event.key)];
  if (arrow) {
    const [dx, dy] = arrow;
    return (hands) => {
      hands.press(x, y);
      if (event.shiftKey) hands.pan(x, y, x + dx, y + dy);
      else hands.orbit(dx, dy);
    };
  }
  if (event.key === "+" || event.key === "=") return (hands) => hands.zoom(x, y, 1 / 1.2);
  if (event.key === "-" || event.key === "_") return (hands) => hands.zoom(x, y, 1.2);
  if (event.key === "Enter") return (hands) => hands.pick(x, y);
  return null;
}
