# awk -v heading=TEXT -v folder=FOLDER -f readme_files.awk README.md
# Writes the files that are printed below a heading of README.md into a folder: blocks of CMake and C++ under the name in
# their first line ("// lidar.cpp"), and what is typed into a shell as commands.sh.
/^## / { below = $0 == "## " heading }
below && /^```(cmake|cpp|sh)$/ { file = $0 == "```sh" ? "commands.sh" : ""; inside = 1; next }
/^```$/ { inside = 0 }
below && inside {
  if (file == "") file = $2
  print > (folder "/" file)
}
