# Listening to 100,000 messages of one publisher, 10,000 a second (watch: 5,000), beside mosquitto_sub: how many are heard, and
# what a message costs the listener. Faster than some 40,000 a second mosquitto drops messages, whoever listens.
mkdir -p "$home/heard"
rm -f "$folder/listening.txt"
yes "$(printf 'x%.0s' {1..1000})" | head -n 1000 >"$home/heard/1k.txt" || true
node tests/bench/state_lines.mjs "$home/heard/2k.txt" 1000
# listen NAME LINES SECONDS COUNT COMMAND…: each 1,000 lines in so many seconds, a hundred times. COUNT prints how many were heard.
listen() {
  local name=$1 lines=$home/heard/$2 each=$3 count=$4 start end ticks peak pid
  helper "${@:5}"
  sleep 1  # until it has subscribed
  pid=$(pgrep -P "${helpers[-1]}" || echo "${helpers[-1]}")
  start=$(date +%s.%N)
  for _ in {1..100}; do
    cat "$lines"
    sleep "$each"
  done | mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t vda5050/v3/KIT/0001/state -q 1 -l
  end=$(date +%s.%N)
  sleep 1
  ticks=$(awk '{ print $14 + $15 }' "/proc/$pid/stat")
  peak=$(awk '/VmHWM/ { print $2 }' "/proc/$pid/status")
  kill -INT "$pid" && wait "${helpers[-1]}" || true  # writes what waits
  unset 'helpers[-1]'
  awk -v n="$($count)" -v wall="$(awk "BEGIN { print $end - $start }")" \
    -v cpu="$(awk "BEGIN { print $ticks / $(getconf CLK_TCK) }")" -v peak="$peak" -v name="$name" 'BEGIN {
    printf "%-16s %6s of 100000 heard, %5.0f a second; %4.1f us of CPU each, %2.0f %% of a core; %d MB\n",
      name, n, 100000 / wall, cpu * 10, cpu / wall * 100, peak / 1024 }' | tee -a "$folder/listening.txt"
}
heading 'listening to 100,000 messages of 1 KB'
written() { grep -c '"topic"' "$home/heard/written"; }
unpacked() { zstd -qdc "$home/heard/written.zst" | grep -c '"topic"'; }
listen record 1k.txt 0.09 written $fleetpub record -f "$home/heard/written"
listen 'record, .zst' 1k.txt 0.09 unpacked $fleetpub record -f "$home/heard/written.zst"
listen mosquitto_sub 1k.txt 0.09 written sh -c \
  "exec mosquitto_sub -h 127.0.0.1 -p $broker_port -t 'vda5050/#' -F %j >$home/heard/written"
heading 'listening to 100,000 states of 2 KB'
validated() { jq -s 'map(.messages // empty) | add' <"$said"; }
listen 'validate --live' 2k.txt 0.09 validated $fleetpub validate --live -o json --quiet
listen mosquitto_sub 2k.txt 0.09 written sh -c \
  "exec mosquitto_sub -h 127.0.0.1 -p $broker_port -t 'vda5050/#' -F %j >$home/heard/written"
unknown() { echo '?'; }
listen 'watch, 5,000/s' 2k.txt 0.19 unknown script -qfc "exec $fleetpub watch" /dev/null
heading 'fleet of 10,000 robots at once; replay of a second at speed 1'
helper $fleetpub simulate KIT/000001 --count 10000 --state-interval 1h --vda 3.0
await_helper grep -q online "$said"
/usr/bin/time -f "fleet            10000 robots: %e s, %U s of CPU in the program, %M KB" -o "$home/heard/took" $fleetpub fleet >/dev/null
end_helper
tee -a "$folder/listening.txt" <"$home/heard/took"
$fleetpub record -f "$home/heard/second.jsonl" --for 1s >/dev/null &
sleep 0.3
for _ in {1..20}; do head -n 1 "$home/heard/2k.txt"; sleep 0.03; done |
  mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t vda5050/v3/KIT/0001/state -l
wait $!
$fleetpub replay "$home/heard/second.jsonl" --force -o json | jq -r '"replay           \(.messages) messages, the latest \(.latestMs) ms behind its time"' |
  tee -a "$folder/listening.txt"
rm -r "$home/heard"
