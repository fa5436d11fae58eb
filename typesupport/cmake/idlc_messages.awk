# Rewrites idlc's messages: they name the original files, and not the copies below $COPIES that idlc read. Syntax errors
# also show the line, and advice for the most frequent causes.
BEGIN {
  advice["wstring"] = "wide strings are not supported: use string, which holds UTF-8"
  advice["map"] = "maps are not supported: use a sequence of structs of key and value"
  advice["any"] = "any is not supported: name the type"
  advice["fixed"] = "fixed-point numbers are not supported: use an integer or double"
  advice["bitset"] = "bitsets are not supported: use a bitmask, or an unsigned integer and constants"
  advice["interface"] = "interfaces are not supported: declare structs only"
  advice["valuetype"] = "value types are not supported: use a struct"
  advice[">>"] = "idlc reads >> as one token: write > >"
}

function line_of(file, number, line, i) {
  for (i = 0; i < number && (getline line < file) > 0; ++i);
  close(file)
  return i == number ? line : ""
}

# Returns the word or sign that starts at a column of a line.
function token_at(line, column) {
  line = substr(line, column)
  if (match(line, /^[A-Za-z_0-9]+/) || match(line, /^>+/)) return substr(line, 1, RLENGTH)
  return substr(line, 1, 1)
}

function without_copies(text, at) {
  while (at = index(text, ENVIRON["COPIES"]))
    text = substr(text, 1, at - 1) substr(text, at + length(ENVIRON["COPIES"]))
  return text
}

/:[0-9]+:[0-9]+: syntax error$/ {
  match($0, /:[0-9]+:[0-9]+: syntax error$/)
  split(substr($0, RSTART + 1), place, ":")
  line = line_of(without_copies(substr($0, 1, RSTART - 1)), place[1])
  token = token_at(line, place[2])
  print without_copies($0) (token in advice ? ": " advice[token] : "")
  print line
  next
}

{ print without_copies($0) }
