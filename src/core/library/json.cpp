// See json.hpp.
#include "library/json.hpp"

#include <charconv>
#include <stdexcept>
#include <utility>
#if !defined(__cpp_lib_to_chars)
#include <locale.h>
#include <stdlib.h>
#endif

namespace urdf_ik {

namespace {

// Deeper nesting is refused, since each level is a call.
constexpr int DEEPEST = 64;

// The number that begins the text, and how many characters it takes; 0: there is none. Whatever the locale, "." is the point.
std::size_t read_number(std::string_view text, double& value) {
#if defined(__cpp_lib_to_chars)
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() ? std::size_t(end - text.data()) : 0;
#else
    static const locale_t plain = newlocale(LC_ALL_MASK, "C", nullptr);
    const std::string copy(text.substr(0, text.find_first_not_of("+-.0123456789eE")));
    char* end = nullptr;
    value = strtod_l(copy.c_str(), &end, plain);
    return std::size_t(end - copy.c_str());
#endif
}

class Reader {
public:
    explicit Reader(std::string_view text) : text_(text) {}

    Json whole() {
        Json read = value(0);
        if (next() != '\0' || at_ < text_.size()) fail("text behind the end");
        return read;
    }

private:
    [[noreturn]] void fail(const std::string& problem) const {
        int line = 1;
        for (std::size_t i = 0; i < at_ && i < text_.size(); ++i) line += text_[i] == '\n';
        throw std::invalid_argument("line " + std::to_string(line) + ": " + problem);
    }
    // The next character that is no blank; '\0' at the end.
    char next() {
        while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos) ++at_;
        return at_ < text_.size() ? text_[at_] : '\0';
    }
    void expect(char wanted) {
        if (next() != wanted) fail(std::string("'") + wanted + "' is missing");
        ++at_;
    }
    bool skip(std::string_view word) {
        if (text_.substr(at_, word.size()) != word) return false;
        at_ += word.size();
        return true;
    }

    Json value(int depth) {
        if (depth > DEEPEST) fail("nested too deeply");
        Json read;
        switch (next()) {
            case '{':
                return group(depth);
            case '[':
                return list(depth);
            case '"':
                read.kind = Json::word, read.text = word();
                return read;
            default:
                break;
        }
        if (skip("true")) return read.kind = Json::boolean, read.value = 1.0, read;
        if (skip("false")) return read.kind = Json::boolean, read;
        if (skip("null")) return read;
        const char first = next();
        if (first != '-' && !(first >= '0' && first <= '9')) fail("a value is missing");
        const std::size_t length = read_number(text_.substr(at_), read.value);
        if (length == 0) fail("no number");
        at_ += length;
        return read.kind = Json::number, read;
    }

    // Reads items up to this bracket; item() reads one.
    template <class Item> void sequence(char end, const Item& item) {
        ++at_;
        if (next() == end) return void(++at_);
        for (;;) {
            item();
            if (next() != ',') break;
            ++at_;
        }
        expect(end);
    }
    Json list(int depth) {
        Json read;
        read.kind = Json::list;
        sequence(']', [&] { read.items.push_back(value(depth + 1)); });
        return read;
    }
    Json group(int depth) {
        Json read;
        read.kind = Json::group;
        sequence('}', [&] {
            if (next() != '"') fail("a name is missing");
            std::string name = word();
            expect(':');
            read.members.push_back({std::move(name), value(depth + 1)});
        });
        return read;
    }

    std::string word() {
        std::string read;
        for (++at_; at_ < text_.size() && text_[at_] != '"'; ++at_) {
            if (text_[at_] != '\\') {
                read += text_[at_];
                continue;
            }
            const char code = ++at_ < text_.size() ? text_[at_] : '\0';
            const std::size_t plain = std::string_view("\"\\/bfnrt").find(code);
            if (code == 'u') append(read, code_point());
            else if (code != '\0' && plain != std::string_view::npos) read += "\"\\/\b\f\n\r\t"[plain];
            else fail("no escape");
        }
        if (at_ >= text_.size()) fail("a text has no end");
        return ++at_, read;
    }

    // Four hexadecimal digits behind \u; at_ stands on the last one then.
    unsigned four_digits() {
        unsigned code = 0;
        const char* from = text_.data() + at_ + 1;
        if (at_ + 4 >= text_.size() || std::from_chars(from, from + 4, code, 16).ptr != from + 4) fail("no escape");
        at_ += 4;
        return code;
    }
    unsigned code_point() {
        const unsigned high = four_digits();
        if (high < 0xd800 || high >= 0xdc00 || text_.substr(at_ + 1, 2) != "\\u") return high;
        at_ += 2;
        return 0x10000 + ((high - 0xd800) << 10) + ((four_digits() - 0xdc00) & 0x3ff);
    }
    static void append(std::string& to, unsigned code) {
        const auto more = [&](int shift) { to += char(0x80 | ((code >> shift) & 0x3f)); };
        if (code < 0x80) to += char(code);
        else if (code < 0x800) to += char(0xc0 | (code >> 6)), more(0);
        else if (code < 0x10000) to += char(0xe0 | (code >> 12)), more(6), more(0);
        else to += char(0xf0 | (code >> 18)), more(12), more(6), more(0);
    }

    const std::string_view text_;
    std::size_t at_ = 0;
};

}  // namespace

const Json* Json::find(std::string_view name) const {
    for (const auto& [known, held] : members) {
        if (known == name) return &held;
    }
    return nullptr;
}

Json read_json(std::string_view text) { return Reader(text).whole(); }

}  // namespace urdf_ik
