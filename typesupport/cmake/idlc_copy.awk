# A copy of an IDL file that may be included more than once, and together with others of its kind. Lines keep their
# numbers.
#
# rosidl_adapter declares an alias for each type of array, `typedef double double__36[36];`, in every file that needs
# it. ROS reads each file on its own; idlc reads them together and takes the second for a collision. The name tells
# what it stands for, so that the first is as good as any. Only what stands before the first declaration is looked at:
# there, the modules so far are the scope.
function alias_of(line, name, dimension) {
  sub(/^[ \t]*typedef[ \t]+/, "", line)
  name = line
  sub(/^[^ \t]+[ \t]+/, "", name)
  sub(/[ \t]*;.*/, "", name)
  sub(/[ \t].*/, "", line)
  gsub(/::|</, "__", line)
  gsub(/>/, "", line)
  if (match(name, /\[[0-9]+\]$/)) {
    dimension = substr(name, RSTART + 1, RLENGTH - 2)
    return name == line "__" dimension "[" dimension "]" ? line "__" dimension : ""
  }
  return name == line ? name : ""
}

BEGIN { is_head = 1 }
is_head && /^[ \t]*module[ \t]+[A-Za-z0-9_]+[ \t]*\{[ \t\r]*$/ { scope = scope $2 "_"; print; next }
is_head && /^[ \t]*typedef[ \t]+[^ \t]+[ \t]+[^ \t]+;[ \t\r]*$/ && (alias = alias_of($0)) != "" {
  guard = "SFT_ALIAS_" scope alias
  print "#ifndef " guard "\n#define " guard "\n#line " NR "\n" $0 "\n#endif\n#line " NR + 1
  next
}
!/^[ \t]*(#.*|\/\/.*)?\r?$/ { is_head = 0 }
{ print }
END { print "#pragma once" }
