// Validates a GLB with Khronos' glTF validator (npm package gltf-validator) and prints its report as JSON: FILE.glb
const { readFileSync } = require("fs");
const validator = require("gltf-validator");

validator.validateBytes(new Uint8Array(readFileSync(process.argv[2])), { maxIssues: 1000 }).then(
  (report) => console.log(JSON.stringify(report)),
  (error) => {
    console.error(String(error));
    process.exit(1);
  },
);
