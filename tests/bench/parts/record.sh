# Recording messages of 1 KB, 10,000 a second for ten seconds, beside mosquitto_sub: how many are written, and what a message
# costs the listener. Faster than some 40,000 a second mosquitto drops messages, whoever listens.
heading 'record: 100,000 messages of 1 KB, 10,000 a second'
mkdir -p "$home/record"
yes "$(printf 'x%.0s' {1..1000})" | head -n 1000 >"$home/record/lines" || true
# listen NAME FILE COMMAND…: while it writes into FILE.
listen() {
  local name=$1 file=$home/record/$2 start end ticks peak
  helper "${@:3}"
  sleep 1  # until it has subscribed
  start=$(date +%s.%N)
  for _ in {1..100}; do
    cat "$home/record/lines"
    sleep 0.09
  done | mosquitto_pub -h 127.0.0.1 -p "$broker_port" -t uagv/v2/KIT/0001/state -q 1 -l
  end=$(date +%s.%N)
  sleep 1
  ticks=$(awk '{ print $14 + $15 }' "/proc/${helpers[-1]}/stat")
  peak=$(awk '/VmHWM/ { print $2 }' "/proc/${helpers[-1]}/status")
  end_helper  # writes what waits
  [ ! -e "$file.zst" ] || zstd -qd "$file.zst"
  awk -v n="$(grep -c '"topic"' "$file")" -v wall="$(awk "BEGIN { print $end - $start }")" \
    -v cpu="$(awk "BEGIN { print $ticks / $(getconf CLK_TCK) }")" -v peak="$peak" -v name="$name" 'BEGIN {
    printf "%-14s %6d of 100000 written, %5.0f a second; %4.1f us of CPU each, %2.0f %% of a core; %d MB\n",
      name, n, n / wall, cpu / n * 1e6, cpu / wall * 100, peak / 1024 }' | tee -a "$folder/record.txt"
}
rm -f "$folder/record.txt"
listen record plain.jsonl $fleetpub record -f "$home/record/plain.jsonl"
listen 'record, .zst' packed.jsonl $fleetpub record -f "$home/record/packed.jsonl.zst"
listen mosquitto_sub theirs.jsonl sh -c \
  "exec mosquitto_sub -h 127.0.0.1 -p $broker_port -t 'uagv/#' -F %j >$home/record/theirs.jsonl"
rm -r "$home/record"
