# Many commands over one connection, beside the sending of lines that are ready.
heading 'batch: 100,000 commands built, stamped, validated and recorded at QoS 0, beside the sending of ready lines' fleetpub 'mosquitto_pub -l'
for robot in {1001..1100}; do printf '{"target":"KIT/%s","action":"startPause"}\n' "$robot"; done >"$home/robots.jsonl"
for _ in {1..1000}; do cat "$home/robots.jsonl"; done >"$home/batch.jsonl"
yes "$message" | head -n 100000 >"$home/ready.jsonl" || true
compare 10 'batch, 100000 commands to 100 robots' \
  fleetpub sh -c "exec $fleetpub batch --vda 3.0 --no-check $home/batch.jsonl >$home/results.jsonl" -- \
  'mosquitto_pub -l' "<$home/ready.jsonl" mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t "$topic" -l
rm "$home/batch.jsonl" "$home/ready.jsonl"
