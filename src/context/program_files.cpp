#include "context/program_files.h"

#include <algorithm>
#include <chrono>
#include <cstdlib>
#include <fmt/format.h>
#include <fstream>
#include <random>
#include <vector>

namespace fumarole::gl {

namespace {

namespace fs = std::filesystem;

constexpr const char* kProgram = ".program";
constexpr const char* kUnfinished = ".unfinished";
constexpr std::uintmax_t kMostOfOne = 64u << 20;  ///< bytes; no driver's program comes near

}  // namespace

ProgramStore ProgramFiles::store()
{
    return {.load = [self = shared_from_this()](std::string_view key) { return self->read(key); },
            .store = [self = shared_from_this()](
                         std::string_view key,
                         const std::vector<std::byte>& program) { self->write(key, program); }};
}

ProgramFiles::Account ProgramFiles::account() const
{
    const std::lock_guard lock(lock_);
    return account_;
}

std::vector<std::byte> ProgramFiles::read(std::string_view key)
{
    const std::lock_guard lock(lock_);
    const fs::path file = folder_ / (std::string(key) + kProgram);
    std::error_code error;
    // A pipe of this name would keep us waiting.
    if (!fs::is_regular_file(file, error))
        return {};
    const std::uintmax_t size = fs::file_size(file, error);
    if (error || size > kMostOfOne)
        return {};
    std::vector<std::byte> program(size);
    std::ifstream from(file, std::ios::binary);
    from.read(reinterpret_cast<char*>(program.data()), static_cast<std::streamsize>(size));
    if (!from)
        return {};
    fs::last_write_time(file, fs::file_time_type::clock::now(), error);  // it was used
    ++account_.loaded;
    return program;
}

void ProgramFiles::write(std::string_view key, const std::vector<std::byte>& program)
{
    const std::lock_guard lock(lock_);
    if (!account_.refusal.empty() || program.size() > kMostOfOne)
        return;
    std::error_code error;
    const bool fresh = fs::create_directories(folder_, error);
    if (fresh)
        fs::permissions(folder_, fs::perms::owner_all, error);
    const fs::path file = folder_ / (std::string(key) + kProgram);
    // A folder may be shared by renderers of one process, and by machines with the same numbers of
    // processes: only chance tells their files apart.
    std::random_device chance;
    const fs::path beside =
        folder_ / fmt::format("{}.{:08x}{:08x}{}", key, chance(), chance(), kUnfinished);
    std::ofstream to(beside, std::ios::binary);
    to.write(reinterpret_cast<const char*>(program.data()),
             static_cast<std::streamsize>(program.size()));
    to.close();
    const bool written = to.good();
    if (written)
        fs::rename(beside, file, error);
    if (!written || error) {
        fs::remove(beside, error);
        account_.refusal = fmt::format("{}: can't be written", folder_.string());
        return;
    }
    ++account_.stored;
    if (bytes_)
        *bytes_ += program.size();
    if (!bytes_ || *bytes_ > most_bytes_)
        make_room();
}

void ProgramFiles::make_room()
{
    struct File {
        fs::file_time_type used;
        std::uintmax_t bytes;
        fs::path path;
    };
    std::vector<File> files;
    std::uintmax_t all = 0;
    std::error_code error;
    const auto now = fs::file_time_type::clock::now();
    // Another process may remove what is listed here meanwhile: that is no error.
    for (fs::directory_iterator entry(folder_, error), end; !error && entry != end;
         entry.increment(error)) {
        const fs::path& path = entry->path();
        std::error_code gone;
        const File file{entry->last_write_time(gone), entry->file_size(gone), path};
        if (gone)
            continue;
        if (path.extension() == kUnfinished && now - file.used > std::chrono::hours(1))
            fs::remove(path, gone);
        if (path.extension() != kProgram)
            continue;
        all += file.bytes;
        files.push_back(file);
    }
    if (all > most_bytes_) {
        std::sort(files.begin(), files.end(),
                  [](const File& a, const File& b) { return a.used < b.used; });
        // To three quarters, so that the next program does not begin it again.
        for (const File& file : files) {
            if (all <= most_bytes_ / 4 * 3)
                break;
            fs::remove(file.path, error);
            all -= file.bytes;
        }
    }
    bytes_ = all;
}

std::optional<fs::path> program_folder()
{
    // The XDG base directory specification: a path that is not absolute is to be passed over.
    if (const char* cache = std::getenv("XDG_CACHE_HOME");
        cache != nullptr && fs::path(cache).is_absolute())
        return fs::path(cache) / "fumarole";
    if (const char* home = std::getenv("HOME"); home != nullptr && fs::path(home).is_absolute())
        return fs::path(home) / ".cache" / "fumarole";
    return std::nullopt;
}

}  // namespace fumarole::gl
