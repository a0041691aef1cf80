# Parsing and validating: in one thread without any process around it, and as a program that reads lines.
ours=$(build/release/tests/bench/validation vda5050/3.0.0/instantActions "$home/message.json" 3)
theirs=$(node tests/peers/ajv_validation.mjs schemas/vda5050/3.0.0/instantActions.schema.json "$home/message.json" 3)
printf 'Parse and validate instantActions, one thread: %s/s, compiled ajv %s/s   ratio %s\n' \
  "$ours" "$theirs" "$(awk "BEGIN { printf \"%.2f\", $ours / $theirs }")"
printf 'program,messages_per_second\nfleetpub,%s\najv,%s\n' "$ours" "$theirs" >"$folder/validation-thread.csv"
echo
# beside_ajv TOPIC FILE LABEL: the same lines through `validate --lines` and through a Node program with compiled ajv.
beside_ajv() {
  $fleetpub schema show "vda5050/3.0.0/$1" >"$home/schema.json"
  compare 20 "$3" \
    fleetpub $fleetpub validate --lines "$2" -- \
    'compiled ajv' node tests/peers/ajv_lines.mjs "$home/schema.json" "$2"
}
heading 'validate --lines, whole processes, a word on each line' fleetpub 'compiled ajv'
yes "$message" | head -n 200000 >"$home/actions.jsonl" || true  # yes ends by SIGPIPE
beside_ajv instantActions "$home/actions.jsonl" 'validate 200000 instantActions'
node tests/bench/state_lines.mjs "$home/states.jsonl" 30000
beside_ajv state "$home/states.jsonl" 'validate 30000 states of 2 KB'
