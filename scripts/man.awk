# From the manual's Markdown to one page's: the chapters that are wanted, without links, and tables as lists of terms.
BEGIN {
  page["orders-and-other-messages"] = "fleetpub-publish(1)"
  page["batch"] = "fleetpub-batch(1)"
  page["fleet-watch-await"] = "fleetpub-fleet(1)"
  page["header-ids-and-history"] = page["ledger"] = "fleetpub-history(1)"
  page["soar"] = "fleetpub-soar(1)"
  page["validation"] = page["schemas-of-your-own"] = "fleetpub-validate(1)"
  page["simulate"] = "fleetpub-simulate(1)"
  page["configuration"] = "fleetpub-config(5)"
}
# A link to another page's chapter becomes that page's name, any other one its text.
function plain(text,   link, target) {
  while (match(text, /\[[^]]*\]\([^)]*\)/)) {
    link = target = substr(text, RSTART, RLENGTH)
    sub(/^\[/, "", link)
    sub(/\]\([^)]*\)$/, "", link)
    sub(/.*\(#?/, "", target)
    sub(/\)$/, "", target)
    if (target in page && page[target] != "fleetpub" self) link = page[target]
    text = substr(text, 1, RSTART - 1) link substr(text, RSTART + RLENGTH)
  }
  return text
}
function cells(line) {
  gsub(/\\\|/, "\001", line)
  sub(/^\| */, "", line)
  sub(/ *\|$/, "", line)
  count = split(line, cell, / *\| */)
  for (i = 1; i <= count; ++i) gsub(/\001/, "|", cell[i])
}
/^## / {
  heading = substr($0, 4)
  ours = wanted != "" ? ("|" wanted "|") ~ ("\\|" heading "\\|") : ("|" taken "|") !~ ("\\|" heading "\\|")
  if (ours) print "# " toupper(heading) "\n"
  next
}
/^Contents: / { contents = 1 }
contents { contents = $0 != ""; next }
/^# / { ours = wanted == ""; if (ours) print "# DESCRIPTION\n"; next }
!ours { next }
/^### / { print "## " substr($0, 5); next }
/^\|[-|]+$/ { next }
/^\|/ {
  if (!table) {  # the head: its first two columns speak for themselves
    table = 1
    cells($0)
    for (i = 3; i <= count; ++i) head[i] = cell[i]
    next
  }
  cells(plain($0))
  text = cell[2]
  for (i = 3; i <= count; ++i) if (cell[i] != "" && cell[i] != "the same") text = text (text ~ /[.!?]$/ ? "" : ".") " " toupper(substr(head[i], 1, 1)) substr(head[i], 2) ": " cell[i]
  print cell[1] "\n\n: " text "\n"
  next
}
{ table = 0; print plain($0) }
