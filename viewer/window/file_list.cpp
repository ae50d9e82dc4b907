#include "window/file_list.h"

#include <algorithm>
#include <cctype>
#include <charconv>
#include <fmt/format.h>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <system_error>

#include "scene_input.h"
#include <fumarole/asset/animation.h>
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

namespace fs = std::filesystem;

/// Two files beside each other may be two versions; three, or two with zeros in front, are frames.
constexpr std::size_t kFewest = 3, kFewestWithZeros = 2;

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

/// Whether a .json file is a scene, or was meant to be one.
bool looks_like_scene(const fs::path& file)
{
    constexpr std::size_t kMost = 4U << 20U;
    std::ifstream in(file, std::ios::binary);
    std::string text(kMost, '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    const nlohmann::json json = nlohmann::json::parse(text, nullptr, false);
    const char* keys[] = {"media", "camera", "lights", "surfaces"};
    if (json.is_discarded())  // what is wrong with it is said in the place of its picture
        return std::any_of(std::begin(keys), std::end(keys), [&](const char* key) {
            return text.find(fmt::format("\"{}\"", key)) != std::string::npos;
        });
    return json.is_object() && std::any_of(std::begin(keys), std::end(keys),
                                           [&](const char* key) { return json.contains(key); });
}

/// A run of digits in a name, which may be a frame's number.
struct Number {
    std::size_t begin = 0, length = 0;
    bool zeros = false;  ///< in front
};

std::vector<Number> numbers_in(const std::string& stem)
{
    std::vector<Number> numbers;
    for (std::size_t i = 0; i < stem.size();) {
        std::size_t end = i;
        while (end < stem.size() && is_digit(stem[end]))
            ++end;
        if (end > i)
            numbers.push_back({i, end - i, stem[i] == '0' && end - i > 1});
        i = std::max(end, i + 1);
    }
    return numbers;
}

/// A file as a frame of a sequence: which one, of how many digits.
struct Frame {
    std::size_t file = 0;
    int number = 0;
    Number place;
};

/// The pattern of files that differ in one number: as many signs as the narrowest has digits where
/// one has zeros in front, else one.
std::string pattern_of(const std::string& name, const std::vector<Frame>& frames)
{
    std::size_t digits = 1;
    for (const Frame& frame : frames)
        if (frame.place.zeros)
            digits = digits == 1 ? frame.place.length : std::min(digits, frame.place.length);
    std::string pattern = name;
    const Number& place = frames.front().place;
    return pattern.replace(place.begin, place.length, std::string(digits, '#'));
}

FileEntry sequence_of(const std::vector<FileEntry>& files, const std::string& pattern,
                      const std::vector<Frame>& frames)
{
    FileEntry entry;
    entry.kind = FileEntry::Kind::sequence;
    entry.name = pattern;
    entry.path = (fs::path(files[frames.front().file].path).parent_path() / pattern).string();
    entry.first = frames.front().number;
    entry.last = frames.back().number;
    entry.frames = static_cast<int>(frames.size());
    for (const Frame& frame : frames)
        entry.bytes += files[frame.file].bytes;
    // First frames are often empty.
    entry.pictured = files[frames[frames.size() / 2].file].path;
    return entry;
}

}  // namespace

bool comes_before(const std::string& a, const std::string& b)
{
    std::size_t i = 0, j = 0;
    const auto lower = [](char c) { return std::tolower(static_cast<unsigned char>(c)); };
    while (i < a.size() && j < b.size()) {
        if (is_digit(a[i]) && is_digit(b[j])) {
            const auto digits = [](const std::string& text, std::size_t& at) {
                while (at < text.size() && text[at] == '0')
                    ++at;
                const std::size_t begin = at;
                while (at < text.size() && is_digit(text[at]))
                    ++at;
                return text.substr(begin, at - begin);
            };
            const std::string x = digits(a, i), y = digits(b, j);
            if (x != y)
                return x.size() != y.size() ? x.size() < y.size() : x < y;
            continue;
        }
        if (lower(a[i]) != lower(b[j]))
            return lower(a[i]) < lower(b[j]);
        ++i;
        ++j;
    }
    return a.size() - i != b.size() - j ? a.size() - i < b.size() - j : a < b;
}

std::vector<FileEntry> with_sequences(const std::vector<FileEntry>& files)
{
    // Each number of a name may be the frame's: the one by which most files are alike is.
    std::map<std::string, std::vector<Frame>> alike;
    for (std::size_t i = 0; i < files.size(); ++i) {
        if (files[i].kind != FileEntry::Kind::volume)
            continue;
        const std::string& name = files[i].name;
        for (const Number& place : numbers_in(fs::path(name).stem().string())) {
            Frame frame{i, 0, place};
            const char* begin = name.data() + place.begin;
            if (std::from_chars(begin, begin + place.length, frame.number).ec != std::errc{})
                continue;
            std::string key = name;
            key.replace(place.begin, place.length, 1, '\0');
            alike[key].push_back(frame);
        }
    }
    std::vector<std::vector<Frame>*> groups;
    groups.reserve(alike.size());
    for (auto& [key, frames] : alike)
        groups.push_back(&frames);
    std::stable_sort(groups.begin(), groups.end(), [](const auto* a, const auto* b) {
        return a->size() != b->size() ? a->size() > b->size()
                                      : a->front().place.begin > b->front().place.begin;
    });
    std::vector<FileEntry> result;
    std::set<std::size_t> taken;
    for (std::vector<Frame>* group : groups) {
        std::vector<Frame> frames = *group;
        std::erase_if(frames, [&](const Frame& frame) { return taken.contains(frame.file); });
        if (frames.empty())
            continue;
        const std::string pattern = pattern_of(files[frames.front().file].name, frames);
        // Others than those that the pattern stands for are files of their own.
        std::erase_if(frames, [&](const Frame& frame) {
            return numbered_file(pattern, frame.number) != files[frame.file].name;
        });
        const bool zeros = std::any_of(frames.begin(), frames.end(),
                                       [](const Frame& frame) { return frame.place.zeros; });
        if (frames.size() < (zeros ? kFewestWithZeros : kFewest))
            continue;
        std::sort(frames.begin(), frames.end(),
                  [](const Frame& a, const Frame& b) { return a.number < b.number; });
        result.push_back(sequence_of(files, pattern, frames));
        for (const Frame& frame : frames)
            taken.insert(frame.file);
    }
    for (std::size_t i = 0; i < files.size(); ++i)
        if (!taken.contains(i))
            result.push_back(files[i]);
    return result;
}

std::vector<FileEntry> list_folder(const fs::path& folder)
{
    std::error_code error;
    std::vector<FileEntry> files;
    fs::directory_iterator at(folder, error);
    for (; !error && at != fs::directory_iterator(); at.increment(error)) {
        FileEntry entry;
        entry.name = at->path().filename().string();
        entry.path = at->path().string();
        if (entry.name.starts_with('.'))
            continue;
        std::error_code unknown;
        if (at->is_directory(unknown)) {
            entry.kind = FileEntry::Kind::folder;
        } else {
            const bool volume = command::has_extension(entry.name, ".vdb") ||
                                command::has_extension(entry.name, ".nvdb");
            if (!at->is_regular_file(unknown) ||
                !(volume || (command::is_scene_file(entry.name) && looks_like_scene(at->path()))))
                continue;
            entry.kind = volume ? FileEntry::Kind::volume : FileEntry::Kind::scene;
            entry.bytes = at->file_size(unknown);
            entry.pictured = entry.path;
        }
        files.push_back(std::move(entry));
    }
    if (error)
        throw Error(fmt::format("{}: {}", folder.string(), error.message()));
    std::vector<FileEntry> entries = with_sequences(files);
    std::sort(entries.begin(), entries.end(), [](const FileEntry& a, const FileEntry& b) {
        const bool a_folder = a.kind == FileEntry::Kind::folder,
                   b_folder = b.kind == FileEntry::Kind::folder;
        return a_folder != b_folder ? a_folder : comes_before(a.name, b.name);
    });
    return entries;
}

std::string describe(const FileEntry& entry)
{
    if (entry.kind == FileEntry::Kind::folder)
        return "folder";
    const double kilobytes = static_cast<double>(entry.bytes) * 1e-3;
    std::string size = kilobytes < 1000     ? fmt::format("{:.0f} kB", std::max(kilobytes, 1.0))
                       : kilobytes < 999950 ? fmt::format("{:.1f} MB", kilobytes * 1e-3)
                                            : fmt::format("{:.1f} GB", kilobytes * 1e-6);
    if (entry.kind == FileEntry::Kind::scene)
        return "scene, " + size;
    if (entry.kind != FileEntry::Kind::sequence)
        return size;
    const bool all = entry.last - entry.first + 1 == entry.frames;
    return fmt::format("frames {}..{}{}, {}", entry.first, entry.last,
                       all ? "" : fmt::format(" ({})", entry.frames), size);
}

}  // namespace fumarole::window
