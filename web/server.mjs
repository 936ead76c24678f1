/**
 * Serves the page and the examples on this machine, with the headers that a server of the page should send. Nothing
 * outside the two folders is served.
 *
 *     node web/server.mjs [PORT]
 */

import { createReadStream } from "node:fs";
import { stat } from "node:fs/promises";
import { createServer } from "node:http";
import { extname, join, resolve, sep } from "node:path";
import { fileURLToPath } from "node:url";

const here = fileURLToPath(new URL(".", import.meta.url));

/** The content security policy of the page: what index.html states, and who may frame it, which only a header can say. */
export const POLICY =
  "default-src 'none'; script-src 'self' 'wasm-unsafe-eval'; worker-src 'self'; style-src 'self'; connect-src 'self'; " +
  "img-src 'self' blob: data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

/** Folders by the start of the path. @type {[string, string][]} */
const FOLDERS = [
  ["/examples/", join(here, "examples")],
  // What the examples import from npm, once `npm ci` has run in web/test.
  ["/node_modules/", join(here, "test", "node_modules")],
  ["/", join(here, "dist")],
];

const TYPES = {
  ".css": "text/css",
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".json": "application/json",
  ".svg": "image/svg+xml",
  ".ts": "text/plain",
  ".wasm": "application/wasm",
};

/** @param {string} url @param {[string, string][]} folders @returns {string | null} The file that a request means. */
function fileOf(url, folders) {
  let path;
  try {
    path = decodeURIComponent(new URL(url, "http://localhost").pathname);
  } catch {
    return null;
  }
  for (const [start, folder] of folders) {
    if (!path.startsWith(start)) continue;
    const rest = path.slice(start.length);
    const root = resolve(folder);
    const file = resolve(root, `./${rest === "" || rest.endsWith("/") ? `${rest}index.html` : rest}`);
    return file.startsWith(root + sep) && !file.includes("\0") ? file : null;
  }
  return null;
}

/**
 * Starts serving on 127.0.0.1.
 * @param {number} port 0 for any that is free.
 * @param {{ folders?: [string, string][], policy?: string }} [other] More folders, and another policy than the page's.
 * @returns {Promise<{ url: string, close(): void }>}
 */
export async function serve(port, { folders = [], policy = POLICY } = {}) {
  const all = [...folders, ...FOLDERS];
  const server = createServer(async (request, response) => {
    const file = request.method === "GET" || request.method === "HEAD" ? fileOf(request.url ?? "/", all) : null;
    const found = file && (await stat(file).catch(() => null));
    if (!file || !found || !found.isFile()) {
      response.writeHead(404, { "Content-Type": "text/plain" }).end("not here\n");
      return;
    }
    response.writeHead(200, {
      "Content-Type": TYPES[/** @type {keyof typeof TYPES} */ (extname(file))] ?? "application/octet-stream",
      "Content-Length": found.size,
      "Content-Security-Policy": policy,
      "Cross-Origin-Opener-Policy": "same-origin",
      "Cross-Origin-Resource-Policy": "same-origin",
      "Referrer-Policy": "no-referrer",
      "X-Content-Type-Options": "nosniff",
      "Cache-Control": "no-cache",
    });
    if (request.method === "HEAD") response.end();
    else
      createReadStream(file)
        .on("error", () => response.destroy())
        .pipe(response);
  });
  await new Promise((resolve, reject) => {
    server.once("error", reject);
    server.listen(port, "127.0.0.1", () => resolve(undefined));
  });
  const address = /** @type {import("node:net").AddressInfo} */ (server.address());
  return {
    url: `http://127.0.0.1:${address.port}/`,
    close() {
      server.closeAllConnections();
      server.close();
    },
  };
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const { url } = await serve(Number(process.argv[2] ?? 8000));
  console.log(`The page is at ${url} until this is interrupted.`);
}
