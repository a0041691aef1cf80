// Parses and validates one message over and over in one thread with a compiled ajv schema, for as many seconds as
// asked, and prints how often it did per second.
import { readFileSync } from "node:fs";
import Ajv from "ajv";
import addFormats from "ajv-formats";

const [schemaFile, messageFile, seconds] = process.argv.slice(2);
const ajv = new Ajv({ strict: false });
addFormats(ajv);
const validate = ajv.compile(JSON.parse(readFileSync(schemaFile, "utf8")));
const text = readFileSync(messageFile, "utf8");
const start = process.hrtime.bigint();
let elapsed = 0;
let count = 0;
while ((elapsed = Number(process.hrtime.bigint() - start) / 1e9) < Number(seconds)) {
  for (let i = 0; i < 1000; ++i, ++count) {
    if (!validate(JSON.parse(text))) process.exit(1);
  }
}
console.log((count / elapsed).toFixed(0));
