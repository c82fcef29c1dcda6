// The library for C in WebAssembly, beside what its runtime lacks; tools/wasm.py builds it, and urdf_ik.js calls it.
//
// Nothing is caught there: what a reader throws ends the call as an exception of JavaScript, and the instance is given up.
#include <cstddef>
#include <cstdlib>
#include <exception>

// Throws an Error with this text.
extern "C" __attribute__((import_module("urdf_ik"), import_name("refuse"))) [[noreturn]] void refuse(const char* text);

// The C++ ABI's functions of a throw expression. All that is thrown begins with a std::exception.
extern "C" void* __cxa_allocate_exception(std::size_t size) noexcept { return std::malloc(size); }
extern "C" void __cxa_free_exception(void*) noexcept {}
extern "C" [[noreturn]] void __cxa_throw(void* thrown, void*, void* (*)(void*)) {
    refuse(static_cast<const std::exception*>(thrown)->what());
}
