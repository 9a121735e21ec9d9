# Writes OUT.cpp and OUT.hpp holding the bytes of INPUT as std::string_view slipd::SYMBOL.
file(READ ${INPUT} hex HEX)
string(REGEX REPLACE "([0-9a-f][0-9a-f])" "'\\\\x\\1'," bytes "${hex}")
string(REGEX REPLACE "(('[^']+',)('[^']+',)('[^']+',)('[^']+',)('[^']+',)('[^']+',)('[^']+',)('[^']+',))" "\\1\n" bytes "${bytes}")
get_filename_component(base ${OUT} NAME)
file(WRITE ${OUT}.hpp "#pragma once\n#include <string_view>\nnamespace slipd {\nextern const std::string_view ${SYMBOL};\n}\n")
file(WRITE ${OUT}.cpp "#include \"embedded/${base}.hpp\"\nnamespace slipd {\nnamespace {\nconstexpr char ${SYMBOL}_bytes[] = {\n${bytes}'\\0'};\n}\nconst std::string_view ${SYMBOL}{${SYMBOL}_bytes, sizeof ${SYMBOL}_bytes - 1};\n}\n")
