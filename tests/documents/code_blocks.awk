# awk -v folder=FOLDER [-v heading=TEXT] [-v sources=FOLDER] -f code_blocks.awk DOCUMENT...
# Writes the code blocks of documents into files, in a folder for each document with its name (README, guide). Prints
# the names of these files: "README/first.cpp", or for a block that is not a whole file "guide/5.block functions".
#
# A block of C++ or CMake whose first line is a comment with a file name ("// lidar.cpp") is a whole file of that name.
# Any other block of C++ is part of a file: the word behind "```cpp" names its surroundings
# (tests/documents/surroundings).
#
# heading: write only the blocks below this heading, directly into the folder, and shell commands into commands.sh.
# sources: the folder to which the documents' names are relative. With it, errors of a compiler name the line in the
# document.
function file_name(line) {
  return line ~ /^(\/\/|#) [A-Za-z_]+\.(cpp|txt)$/ ? substr(line, index(line, " ") + 1) : ""
}
FNR == 1 {
  document = FILENAME
  gsub(/.*\/|\.md$/, "", document)
  in_block = parts = 0
  below = heading == ""
  if (heading == "") system("mkdir -p '" folder "/" document "'")
}
/^#+ / && !in_block && heading != "" {
  below = $0 ~ /^## / ? substr($0, 4) == heading : below
  found = found || below
}
/^```/ && in_block { in_block = 0; close(file); next }
/^```/ {
  in_block = 1
  file = ""
  kind = substr($1, 4)
  surroundings = $2
  if (kind == "sh" && heading != "" && below) file = folder "/commands.sh"
  next
}
!in_block || !below { next }
file == "" && kind ~ /^(cpp|cmake)$/ {
  name = file_name($0)
  if (name == "" && (kind == "cmake" || heading != "")) { kind = ""; next }
  if (name == "") {
    name = ++parts ".block"
    if (surroundings == "") {
      print FILENAME ":" FNR - 1 ": this block of C++ is no whole file: " \
        "begin it with '// name.cpp', or name its surroundings" >"/dev/stderr"
      exit 1
    }
  } else surroundings = ""
  path = heading == "" ? document "/" name : name
  file = folder "/" path
  printf "" >file
  if (sources != "") print "#line " FNR " \"" sources "/" FILENAME "\"" >file
  print path (surroundings == "" ? "" : " " surroundings)
}
file != "" { print >file }
END {
  if (heading != "" && !found) {
    print "no document has the heading '## " heading "'" >"/dev/stderr"
    exit 1
  }
}
