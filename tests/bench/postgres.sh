# Sourced by parts/postgres.sh: a PostgreSQL of its own on a free loopback port, which syncs as it does when nobody configures it.
#
# start_postgres    starts it, as another user when we are root, and sets postgres_port and postgres_data, its folder.
#                   It is the last helper (scripts/bench).

start_postgres() {
  local programs as_user=() try folder
  programs=$(find /usr/lib/postgresql -name initdb -printf '%h\n' | sort -V | tail -1)
  folder=$(mktemp -d)  # the other user may not get into ours
  folders+=("$folder")
  if [ "$(id -u)" -eq 0 ]; then
    chown nobody "$folder"
    as_user=(setpriv --reuid nobody --clear-groups)
  fi
  postgres_data=$folder
  (cd / && "${as_user[@]}" "$programs/initdb" -D "$folder" -U postgres -A trust -E UTF8 --locale=C --no-instructions >/dev/null)
  for try in 1 2 3 4 5; do
    postgres_port=$((40000 + RANDOM % 20000))
    helper "${as_user[@]}" "$programs/postgres" -D "$folder" -p "$postgres_port" -c listen_addresses=127.0.0.1 \
      -c unix_socket_directories= -c logging_collector=off
    until grep -q 'ready to accept connections' "$said"; do
      kill -0 "${helpers[-1]}" 2>/dev/null || { unset 'helpers[-1]'; continue 2; }
      sleep 0.02
    done
    return
  done
  cat "$said" >&2
  return 1
}
