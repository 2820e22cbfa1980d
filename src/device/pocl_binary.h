// What PoCL gives out as a program's binary: its LLVM code, and each kernel's machine code with what its arguments are.
#pragma once
#include <vector>

namespace irradia::device {

/// `binary` without the LLVM code, which PoCL reads whenever it takes a program (4 to 19 ms each, more than all else it
/// does to take one) and needs only to compile kernels once more, for single group sizes. What is not just as PoCL 3.1
/// to 5 write it, with machine code that serves all group sizes for every kernel, comes back as it is.
std::vector<unsigned char> without_llvm_code(std::vector<unsigned char> binary);

}  // namespace irradia::device
