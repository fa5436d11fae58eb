# cmake -D FOLDER=folder -D FILES=list -P link.cmake
# Makes a link to each of these files or folders in a folder of the build tree. The links are relative, so that they
# lead to their files where the whole tree was moved, or is seen in another folder, too.
cmake_minimum_required(VERSION 3.22)
file(MAKE_DIRECTORY ${FOLDER})
file(REAL_PATH ${FOLDER} folder)  # ".." in a link is that of the real folder
foreach(file IN LISTS FILES)
  cmake_path(GET file FILENAME name)
  cmake_path(GET file PARENT_PATH parent)
  file(REAL_PATH ${parent} parent)
  file(RELATIVE_PATH path ${folder} ${parent}/${name})
  file(CREATE_LINK ${path} ${folder}/${name} SYMBOLIC)
endforeach()
