# A ledger in PostgreSQL beside one in a file; and how often the database is waited for. The static binary cannot load libpq, so
# both are the release one's.
. tests/bench/postgres.sh
start_postgres
release=build/release/src/fleetpub
database=postgresql://postgres@127.0.0.1:$postgres_port/postgres
$release ledger migrate --ledger "$database" >/dev/null
heading "A ledger in PostgreSQL (on $(findmnt -no FSTYPE -T "$postgres_data")) beside one in a file, release" PostgreSQL SQLite
for count in 1 500 10000; do
  case $count in 1) times=100 ;; 500) times=30 ;; *) times=5 ;; esac
  compare $times "PostgreSQL, $count robots sent" \
    PostgreSQL "<$(names $count)" $release pause - --vda 3.0 --no-check --quiet --ledger "$database" -- \
    SQLite "<$(names $count)" $release pause - --vda 3.0 --no-check --quiet
done
echo
echo 'The database, as it is waited for by one command to 1,000 robots, two batches (strace)'
strace -yy -s 400 -e trace=sendto,recvfrom,writev -o "$home/strace" $release pause - --vda 3.0 --no-check --quiet --ledger "$database" <"$(names 1000)"
python3 tests/bench/round_trips.py "$home/strace" "$postgres_port" "$folder/postgres-round-trips.csv"
echo
# A database 30 ms away: each byte takes 15 ms.
helper build/release/tests/bench/delay "$postgres_port" 15
await_helper test -s "$said"
distant=$(cat "$said")
distant=${database/:$postgres_port/:${distant##*:}}
heading 'The same with a database 30 ms away: 20 batches more' '10500 robots' '500 robots'
compare 5 'PostgreSQL 30 ms away' \
  '10500 robots' "<$(names 10500)" $release pause - --vda 3.0 --no-check --quiet --ledger "$distant" -- \
  '500 robots' "<$(names 500)" $release pause - --vda 3.0 --no-check --quiet --ledger "$distant"
end_helper
end_helper
