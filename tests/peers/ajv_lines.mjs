// Validates a file of JSON Lines with a compiled ajv schema and prints what is wrong with which line.
//   ajv_lines.mjs SCHEMA FILE
import { readFileSync } from "node:fs";
import Ajv from "ajv";
import addFormats from "ajv-formats";

const [schemaFile, messageFile] = process.argv.slice(2);
const ajv = new Ajv({ strict: false });
addFormats(ajv);
const validate = ajv.compile(JSON.parse(readFileSync(schemaFile, "utf8")));
readFileSync(messageFile, "utf8").split("\n").forEach((line, i) => {
  if (line === "" || validate(JSON.parse(line))) return;
  console.log(i + 1, ajv.errorsText(validate.errors));
  process.exitCode = 3;
});
