// The published schemas of VDA 5050, with the corrections that ours have. Each of our files names its own in `$comment`.
import { readFileSync } from "node:fs";

const HEADER = ["headerId", "timestamp", "version", "manufacturer", "serialNumber"];
const HEADER_ID = { type: "integer", minimum: 0, maximum: 4294967295 };
const COMMUNITY = "http://vda-5050-schema.org/v1.1/";

// {dialect, schema, others, base, resolve}: others are documents that it refers to, resolve finds what a reference means.
export function corrected(reference, version, topic) {
  const folder = `${reference}/vda5050/${version}`;
  return version === "1.1.0" ? community(`${folder}-community`, topic) : official(folder, version, topic);
}

function official(folder, version, topic) {
  let text = readFileSync(`${folder}/${topic}.schema.json`, "utf8").replace(/^\uFEFF/, "");
  // One comma too many, as published.
  if (version === "2.0.0" && topic === "state") text = text.replace(/,(\s*[}\]])/, "$1");
  const schema = JSON.parse(text);
  schema.properties.headerId = HEADER_ID;
  schema.properties.timestamp = { type: "string", format: "date-time" };
  schema.required = [...new Set([...HEADER, ...(schema.required ?? [])])];
  if (topic === "factsheet" && version !== "3.0.0") {
    const types = schema.properties.protocolFeatures.properties.agvActions.items.properties.blockingTypes;
    types.items = { type: "string", enum: types.enum };
    delete types.enum;
  }
  if (topic === "state" && version === "2.1.0") schema.properties.actionStates.items.properties.actionStatus.enum.push("PAUSED");
  const resolve = (uri) => ({ schema: follow(schema, uri.slice(1)), base: "" });
  return { dialect: "2020-12", schema, others: [], base: "", resolve };
}

function community(folder, topic) {
  const limited = (_, value) => (value === 4294967296 ? 4294967295 : value);
  const read = (name) => JSON.parse(readFileSync(`${folder}/${name}.schema.json`, "utf8"), limited);
  const common = read("common");
  common.definitions.header.properties.headerId = HEADER_ID;
  const schema = read(topic === "instantActions" ? "instant-actions" : topic);
  const resolve = (uri) => ({ schema: follow(common, uri.replace(`${COMMUNITY}common.schema.json#`, "")), base: "" });
  return { dialect: "draft-07", schema, others: [common], base: "", resolve };
}

const follow = (root, pointer) => pointer.split("/").slice(1).reduce((value, name) => value[name], root);
