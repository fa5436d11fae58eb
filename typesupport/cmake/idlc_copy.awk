# Copies an IDL file for idlc. The copy avoids these faults of idlc:
# - idlc includes a file without an include guard twice. The copy ends with `#pragma once`.
# - rosidl_adapter declares an alias for each type of array, `typedef double double__36[36];`, in every file that needs
#   it. ROS reads each file on its own, but idlc reads all together and reports the second alias as a collision. The
#   copy guards each alias, since its name says what it means. It does so only before the first declaration, where the
#   modules so far are the scope.
# - idlc counts lines wrongly beside comments, and sometimes elsewhere. The copy has no comments, and a number for each
#   line. Columns do not change.
# - idlc misreads the letters in "\x7e". The copy has "\176".
# - idlc drops annotations that are not declared. The copy declares @sft_layout.
function blank(width, spaces) {
  while (length(spaces) < width) spaces = spaces " "
  return spaces
}

function hex_value(digits, i, value) {
  for (i = 1; i <= length(digits); ++i)
    value = 16 * value + index("0123456789abcdef", tolower(substr(digits, i, 1))) - 1
  return value
}

# Replaces the hexadecimal escapes of a string or character literal by octal ones.
function without_hex(literal, result, escape) {
  while (match(literal, /\\([xX][0-9A-Fa-f][0-9A-Fa-f]?|.)/)) {
    escape = substr(literal, RSTART, RLENGTH)
    if (length(escape) > 2) escape = sprintf("\\%03o", hex_value(substr(escape, 3)))
    result = result substr(literal, 1, RSTART - 1) escape
    literal = substr(literal, RSTART + RLENGTH)
  }
  return result literal
}

# Replaces comments in `line` by spaces, and hexadecimal escapes by octal ones. Remembers a comment of several lines.
function without_comments(line, result, literal) {
  result = ""
  while (line != "") {
    if (in_comment) {
      if (!match(line, /\*\//)) return result
      result = result blank(RSTART + 1)
      line = substr(line, RSTART + 2)
      in_comment = 0
    } else if (match(line, /^([^"'\/]|\/[^\/*]|\/$)+/)) {
      result = result substr(line, 1, RLENGTH)
      line = substr(line, RLENGTH + 1)
    } else if (match(line, /^"([^"\\]|\\.)*"?/) || match(line, /^'([^'\\]|\\.)*'?/)) {
      literal = substr(line, 1, RLENGTH)
      result = result without_hex(literal)
      line = substr(line, length(literal) + 1)
    } else if (line ~ /^\/\*/) {
      result = result "  "
      line = substr(line, 3)
      in_comment = 1
    } else {
      return result  # the rest of the line is a comment
    }
  }
  return result
}

# Returns the name of an alias if rosidl_adapter would declare it like this; otherwise an empty string.
function alias_of(line, name, dimension) {
  sub(/^[ \t]*typedef[ \t]+/, "", line)
  name = line
  sub(/^[^ \t]+[ \t]+/, "", name)
  sub(/[ \t]*;.*/, "", name)
  sub(/[ \t].*/, "", line)
  gsub(/::|</, "__", line)
  gsub(/>/, "", line)
  if (!match(name, /\[[0-9]+\]$/)) return name == line ? name : ""
  dimension = substr(name, RSTART + 1, RLENGTH - 2)
  return name == line "__" dimension "[" dimension "]" ? line "__" dimension : ""
}

BEGIN {
  is_head = 1
  print "#ifndef SFT_LAYOUT_ANNOTATION\n#define SFT_LAYOUT_ANNOTATION"
  print "@annotation sft_layout { string value; };\n#endif"
}

{
  sub(/\r$/, "")
  line = without_comments($0)
  alias = ""
  if (is_head && line ~ /^[ \t]*typedef[ \t]+[^ \t]+[ \t]+[^ \t]+;[ \t]*$/) alias = alias_of(line)
  if (is_head && line ~ /^[ \t]*module[ \t]+[A-Za-z0-9_]+[ \t]*\{[ \t]*$/) scope = scope $2 "_"
  else if (line !~ /^[ \t]*(#.*)?$/ && alias == "") is_head = 0

  if (alias != "") print "#ifndef SFT_ALIAS_" scope alias "\n#define SFT_ALIAS_" scope alias
  if (!is_continued) print "#line " NR
  print line
  if (alias != "") print "#endif"
  is_continued = line ~ /\\$/
}

END { print "#pragma once" }
