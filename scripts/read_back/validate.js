// Paths of GLBs on standard input, one per line -> one line of JSON for each, by the Khronos glTF validator.
// usage: NODE_PATH=.../node_modules node validate.js
const fs = require("fs");
const readline = require("readline");
const validator = require("gltf-validator");

(async () => {
  for await (const path of readline.createInterface({ input: process.stdin })) {
    const { issues, info } = await validator.validateBytes(new Uint8Array(fs.readFileSync(path)), { maxIssues: 20 });
    const told = issues.messages.filter((message) => message.severity < 2);
    const answer = { errors: issues.numErrors, warnings: issues.numWarnings, triangles: info.totalTriangleCount, told };
    console.log(JSON.stringify(answer));
  }
})();
