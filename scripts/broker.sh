# Sourced by scripts/demo and scripts/bench: a mosquitto of their own on a free loopback port.
#
# start_broker FOLDER PING…   starts it with its files in FOLDER, waits until the command PING succeeds, and sets
#                             broker_port and broker_pid; FLEETPUB_BROKER is exported.
# stop_broker                 stops it by its pid.

broker_pid=

start_broker() {
  local folder=$1 try
  shift
  # A free port cannot be reserved, only tried: when somebody else was faster, mosquitto ends and the next is tried.
  for try in 1 2 3 4 5 6 7 8 9 10; do
    broker_port=$((4000 + RANDOM % 6000))
    printf 'listener %s 127.0.0.1\nallow_anonymous true\n' "$broker_port" >"$folder/mosquitto.conf"
    PATH=$PATH:/usr/sbin mosquitto -c "$folder/mosquitto.conf" >"$folder/mosquitto.log" 2>&1 &
    broker_pid=$!
    export FLEETPUB_BROKER=mqtt://127.0.0.1:$broker_port
    while kill -0 "$broker_pid" 2>/dev/null; do
      "$@" >/dev/null 2>&1 && grep -q ' running$' "$folder/mosquitto.log" && return 0  # and not the somebody else
    done
  done
  broker_pid=
  echo "no broker could be started:" >&2
  cat "$folder/mosquitto.log" >&2
  return 1
}

stop_broker() {
  [ -n "$broker_pid" ] || return 0
  kill "$broker_pid" 2>/dev/null
  wait "$broker_pid" 2>/dev/null
  broker_pid=
}
