#include "window/font_files.h"

#include <cstdint>
#include <cstring>
#include <dlfcn.h>
#include <fstream>
#include <iterator>
#include <memory>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

/// Whether Dear ImGui can read it: outlines of TrueType or of CFF, not compressed for the web.
bool is_readable_font(const std::string& data)
{
    for (const char* begin : {"\0\1\0\0", "true", "OTTO", "ttcf"})
        if (data.size() > 12 && std::memcmp(data.data(), begin, 4) == 0)
            return true;
    return false;
}

std::string read_font(const fs::path& file)
{
    std::ifstream input(file, std::ios::binary);
    std::string data{std::istreambuf_iterator<char>(input), {}};
    return is_readable_font(data) ? data : "";
}

template <typename T> std::unique_ptr<T, void (*)(T*)> owned(T* object, void (*destroy)(T*))
{
    return {object, destroy};
}

/// Fontconfig 2's functions, from its library as it is opened: the window alone needs it, and only
/// once it shows a letter that our own font lacks, so no command is linked with it.
class Fontconfig {
public:
    Fontconfig() : library_{::dlopen("libfontconfig.so.1", RTLD_LAZY | RTLD_LOCAL)}
    {
        const bool all =
            library_ != nullptr && get(load, "FcInitLoadConfigAndFonts") &&
            get(unload, "FcConfigDestroy") && get(make_pattern, "FcPatternCreate") &&
            get(destroy_pattern, "FcPatternDestroy") && get(make_letters, "FcCharSetCreate") &&
            get(destroy_letters, "FcCharSetDestroy") && get(add_letter, "FcCharSetAddChar") &&
            get(has_letter, "FcCharSetHasChar") && get(set_letters, "FcPatternAddCharSet") &&
            get(set_bool, "FcPatternAddBool") && get(substitute, "FcConfigSubstitute") &&
            get(set_defaults, "FcDefaultSubstitute") && get(sort, "FcFontSort") &&
            get(destroy_set, "FcFontSetDestroy") && get(get_letters, "FcPatternGetCharSet") &&
            get(get_bool, "FcPatternGetBool") && get(get_integer, "FcPatternGetInteger") &&
            get(get_string, "FcPatternGetString");
        config_ = all ? load() : nullptr;
    }
    ~Fontconfig()
    {
        if (config_ != nullptr)
            unload(config_);
        if (library_ != nullptr)
            ::dlclose(library_);
    }
    Fontconfig(const Fontconfig&) = delete;
    Fontconfig& operator=(const Fontconfig&) = delete;

    [[nodiscard]] bool usable() const { return config_ != nullptr; }

    [[nodiscard]] std::vector<FontFile> find(std::set<char16_t> letters) const
    {
        const auto wanted = owned(make_letters(), destroy_letters);
        for (const char16_t letter : letters)
            add_letter(wanted.get(), letter);
        const auto pattern = owned(make_pattern(), destroy_pattern);
        set_letters(pattern.get(), "charset", wanted.get());
        set_bool(pattern.get(), "scalable", 1);
        substitute(config_, pattern.get(), kMatchPattern);
        set_defaults(pattern.get());
        int result = 0;
        const auto sorted = owned(sort(config_, pattern.get(), 0, nullptr, &result), destroy_set);
        std::vector<FontFile> fonts;
        for (int i = 0; sorted != nullptr && i < sorted->count && !letters.empty(); ++i) {
            FontFile font = look_at(sorted->fonts[i], letters);
            if (font.letters.empty())
                continue;
            font.data = read_font(font.file);
            if (font.data.empty())
                continue;
            for (const char16_t letter : font.letters)
                letters.erase(letter);
            fonts.push_back(std::move(font));
        }
        return fonts;
    }

private:
    using Config = void;
    using Pattern = void;
    using Letters = void;
    struct FontSet {
        int count, room;
        Pattern** fonts;
    };
    static constexpr int kMatchPattern = 0;

    template <typename Function> bool get(Function*& function, const char* name)
    {
        function = reinterpret_cast<Function*>(::dlsym(library_, name));
        return function != nullptr;
    }
    /// What a font has of the letters; none if its letters have colours or no outlines.
    FontFile look_at(Pattern* font, const std::set<char16_t>& letters) const
    {
        FontFile found;
        const char* file = nullptr;
        Letters* has = nullptr;
        int scalable = 0, coloured = 0, index = 0;
        get_bool(font, "scalable", 0, &scalable);
        get_bool(font, "color", 0, &coloured);
        if (scalable == 0 || coloured != 0 || get_string(font, "file", 0, &file) != 0 ||
            get_letters(font, "charset", 0, &has) != 0)
            return found;
        get_integer(font, "index", 0, &index);
        found.file = file;
        found.index = index & 0xffff;  // above it stands the instance of a variable font
        for (const char16_t letter : letters)
            if (has_letter(has, letter) != 0)
                found.letters.insert(letter);
        return found;
    }

    void* library_;
    Config* config_ = nullptr;
    Config* (*load)() = nullptr;
    void (*unload)(Config*) = nullptr;
    Pattern* (*make_pattern)() = nullptr;
    void (*destroy_pattern)(Pattern*) = nullptr;
    Letters* (*make_letters)() = nullptr;
    void (*destroy_letters)(Letters*) = nullptr;
    int (*add_letter)(Letters*, std::uint32_t) = nullptr;
    int (*has_letter)(const Letters*, std::uint32_t) = nullptr;
    int (*set_letters)(Pattern*, const char*, const Letters*) = nullptr;
    int (*set_bool)(Pattern*, const char*, int) = nullptr;
    int (*substitute)(Config*, Pattern*, int kind) = nullptr;
    void (*set_defaults)(Pattern*) = nullptr;
    FontSet* (*sort)(Config*, Pattern*, int trim, Letters**, int* result) = nullptr;
    void (*destroy_set)(FontSet*) = nullptr;
    int (*get_letters)(const Pattern*, const char*, int n, Letters**) = nullptr;
    int (*get_bool)(const Pattern*, const char*, int n, int*) = nullptr;
    int (*get_integer)(const Pattern*, const char*, int n, int*) = nullptr;
    int (*get_string)(const Pattern*, const char*, int n, const char**) = nullptr;
};

/// What Debian's packages install, that with the most scripts first.
std::vector<FontFile> find_in_known_places(const std::set<char16_t>& letters)
{
    std::vector<FontFile> fonts;
    for (const char* name :
         {"wqy/wqy-microhei.ttc", "droid/DroidSansFallbackFull.ttf", "dejavu/DejaVuSans.ttf"}) {
        const fs::path file = fs::path("/usr/share/fonts/truetype") / name;
        if (std::string data = read_font(file); !data.empty())
            fonts.push_back({file, 0, std::move(data), letters});
    }
    return fonts;
}

}  // namespace

std::vector<FontFile> find_fonts(std::set<char16_t> letters)
{
    const Fontconfig fontconfig;
    return fontconfig.usable() ? fontconfig.find(std::move(letters))
                               : find_in_known_places(letters);
}

}  // namespace fumarole::window
