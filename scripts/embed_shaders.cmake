# Writes a .cpp that holds every file of a folder as a string, by its path below the folder.
#   cmake -DFOLDER=glsl -DOUTPUT=shader_files.cpp -P embed_shaders.cmake
file(GLOB_RECURSE files RELATIVE ${FOLDER} ${FOLDER}/*)
list(SORT files)
set(text "#include \"gl/program.h\"\n\nnamespace fumarole::gl {\n\n"
         "const std::map<std::string, std::string_view, std::less<>>& shader_files()\n{\n"
         "    static const std::map<std::string, std::string_view, std::less<>> files{\n")
foreach(file ${files})
  file(READ ${FOLDER}/${file} source)
  string(APPEND text "{\"${file}\", R\"glsl(${source})glsl\"},\n")
endforeach()
string(APPEND text "    };\n    return files;\n}\n\n}  // namespace fumarole::gl\n")
file(WRITE ${OUTPUT} "${text}")
