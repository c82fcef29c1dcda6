// One arm on a Cortex-M7 without an operating system or heap: how many poses have the counts of the host, and how much stack was
// used. It speaks by semihosting.
#include "arm.hpp"
#include "poses.hpp"

static double q[arm::columns * arm::joints];
static uint8_t flags[arm::columns];

static void semihost(int operation, const void* argument) {
    register int r0 __asm__("r0") = operation;
    register const void* r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}
static void say(const char* text) { semihost(4, text); }
static void say(long number) {
    char digits[12], *at = digits + 11;
    for (*at = 0; number || !*at; number /= 10) *--at = char('0' + number % 10);
    say(at);
}
[[noreturn]] static void leave() {
    semihost(0x18, reinterpret_cast<const void*>(0x20026));
    for (;;) {}
}

extern "C" {
// The heap is not to be asked for.
void* _sbrk(int) {
    say("heap asked for\n");
    leave();
}
extern unsigned stack_top[], data_from[], data_begin[], data_end[], bss_begin[], bss_end[];
}

static constexpr unsigned UNTOUCHED = 0xdeadbeef;

static void solve_all() {
    long same = 0, solutions = 0;
    for (int i = 0; i < POSES; ++i) {
        const int count = arm::ik(poses[i], q, flags);
        solutions += count, same += count == counts[i];
    }
    const unsigned* word = bss_end;
    while (*word == UNTOUCHED) ++word;
    say(same), say(" "), say(long(POSES)), say(" "), say(solutions), say(" ");
    say(long(stack_top - word) * 4), say("\n");
}

extern "C" [[noreturn]] void start() {
    *reinterpret_cast<volatile unsigned*>(0xE000ED88) |= 0xfu << 20;  // the floating-point unit
    __asm__ volatile("dsb\nisb");
    for (unsigned *to = data_begin, *from = data_from; to < data_end;) *to++ = *from++;
    for (unsigned* to = bss_begin; to < bss_end;) *to++ = 0;
    unsigned* const here = static_cast<unsigned*>(__builtin_frame_address(0)) - 64;
    for (unsigned* to = bss_end; to < here;) *to++ = UNTOUCHED;
    solve_all();
    leave();
}
extern "C" [[noreturn]] void fault() {
    say("fault\n");
    leave();
}
using Vector = void (*)();
__attribute__((section(".vectors"), used)) static const Vector vectors[16] = {
    reinterpret_cast<Vector>(stack_top), start, fault, fault, fault, fault, fault};
