#include "window/grid_router.h"

#include <algorithm>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <new>

#include "window/glfw_window.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/frame_loader.h>
#include <fumarole/asset/sequence.h>
#include <fumarole/asset/vdb_file.h>
#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

/// Of files whose values are read for the ranges that the lists show.
constexpr std::uint64_t kMostMeasured = 64U << 20U;

std::string why(const std::exception& error)
{
    return dynamic_cast<const std::bad_alloc*>(&error) != nullptr ? "out of memory" : error.what();
}

/// The fullest frame of a sequence's grid.
int fullest_frame(const std::vector<asset::SequenceFrame>& frames, const std::string& grid)
{
    return std::max_element(frames.begin(), frames.end(),
                            [&](const auto& a, const auto& b) {
                                return asset::voxels_in(a.file, grid) <
                                       asset::voxels_in(b.file, grid);
                            })
        ->frame;
}

/// Chooses what the new parts of a medium are multiplied by; of a sequence by the frames that have
/// the most of them.
void fit(GridMedium& medium, const std::string& file, asset::NewGrids which)
{
    if (!which.density && !which.emission && !which.temperature)
        return;
    GridMedium fullest = medium;
    fullest.file = file;
    if (is_sequence(file)) {
        const std::vector<asset::SequenceFrame> frames = asset::read_sequence(file);
        const auto take = [&](bool wanted, const std::string& grid,
                              std::shared_ptr<const VoxelGrid>& voxels) {
            if (wanted)
                voxels = std::make_shared<const VoxelGrid>(
                    asset::load_grid(frame_file(file, fullest_frame(frames, grid)), grid).grid);
        };
        take(which.density, fullest.grid, fullest.density);
        take(which.emission, fullest.emission_grid, fullest.emission);
        take(which.temperature, fullest.temperature_grid, fullest.temperature);
        fullest.temperature_scale = which.temperature ? 0 : fullest.temperature_scale;
    }
    asset::fit_medium(fullest, which);
    medium.sigma_s_per_density = fullest.sigma_s_per_density;
    medium.sigma_a_per_density = fullest.sigma_a_per_density;
    medium.emission_per_unit = fullest.emission_per_unit;
    medium.temperature_scale = fullest.temperature_scale;
    medium.blackbody_intensity = fullest.blackbody_intensity;
}

/// Reads what a medium lacks of a frame's grids.
/// @param moving the same with the #s of a sequence
GridRouter::Routed read(RoutedMedium routed, GridMedium moving, double frames_per_second, int frame)
{
    GridMedium& medium = routed.medium;
    // What is spread along its way is made of all of its grids at once.
    if (medium.motion.shutter > 0 && !medium.motion.velocity_grid.empty())
        medium.density = medium.emission = medium.color = medium.temperature = nullptr;
    const std::string file = moving.file;
    moving = medium;
    moving.file = file;
    moving.density = moving.emission = moving.color = moving.temperature = nullptr;
    Scene only, like;
    only.frames_per_second = frames_per_second;
    only.media = {moving};
    like.media = {medium};
    asset::LoadedScene loaded = asset::load_frame(only, frame, like);
    GridRouter::Routed result{0, frame, std::get<GridMedium>(loaded.scene.media.front()),
                              std::move(loaded.notes)};
    fit(result.as, file, routed.fit);
    return result;
}

}  // namespace

void GridRouter::open(const Scene& moving)
{
    shared_ = std::make_shared<Shared>();
    waiting_.clear();
    running_.reset();
    routing_.stop();
    lists_.assign(moving.media.size(), {});
    memory_.assign(moving.media.size(), {});
    files_.assign(moving.media.size(), "");
    std::vector<std::string> files;
    for (std::size_t i = 0; i < moving.media.size(); ++i)
        if (const auto* grid = std::get_if<GridMedium>(&moving.media[i])) {
            files_[i] = grid->file;
            if (!grid->file.empty() &&
                std::find(files.begin(), files.end(), grid->file) == files.end())
                files.push_back(grid->file);
        }
    for (std::size_t i = 0; i < files_.size(); ++i)
        lists_[i].listed = files_[i].empty();
    if (!files.empty())
        listing_.run([files, shared = shared_](const Background::Stop& stop) {
            read_lists(files, *shared, stop);
        });
}

void GridRouter::read_lists(const std::vector<std::string>& files, Shared& shared,
                            const Background::Stop& stop)
{
    const auto publish = [&](Listed listed) {
        {
            const std::lock_guard lock(shared.lock);
            shared.listed.push_back(std::move(listed));
        }
        GlfwWindow::wake();
    };
    std::vector<std::string> small;
    for (const std::string& file : files) {
        if (stop)
            return;
        try {
            if (is_sequence(file)) {
                publish({file, grid_rows(asset::all_grids(asset::read_sequence(file)), false), ""});
                continue;
            }
            const asset::VdbInfo headers = asset::read_vdb_headers(file);
            publish({file, grid_rows(headers, false), ""});
            if (headers.file_bytes <= kMostMeasured)
                small.push_back(file);
        } catch (const std::exception& error) {
            publish({file, {}, why(error)});
        }
    }
    for (const std::string& file : small) {
        if (stop)
            return;
        try {
            publish({file, grid_rows(asset::inspect_vdb(file), true), ""});
        } catch (const std::exception&) {
            // Its ranges are not known; what is wrong with it is said where it is shown.
        }
    }
}

void GridRouter::take_listed()
{
    std::vector<Listed> listed;
    {
        const std::lock_guard lock(shared_->lock);
        listed.swap(shared_->listed);
    }
    for (Listed& one : listed)
        for (std::size_t i = 0; i < files_.size(); ++i)
            if (files_[i] == one.file) {
                lists_[i].rows = one.rows;
                lists_[i].listed = true;
                if (!one.error.empty())
                    lists_[i].error = one.error;
            }
}

void GridRouter::ask(std::size_t medium, const std::string& grid, GridRole role)
{
    if (medium >= lists_.size() || files_[medium].empty())
        throw Error(fmt::format("medium {} has no file of grids", medium));
    GridList& list = lists_[medium];
    list.error.clear();
    list.wrong = grid;
    const auto row = find_row(list.rows, grid);
    if (!row) {
        std::vector<std::string> names;
        for (const GridRow& known : list.rows)
            names.push_back(known.name);
        list.error =
            fmt::format("{}: no grid '{}' (has: {})", files_[medium], grid, fmt::join(names, ", "));
        return;
    }
    if (const std::string refusal = role_refusal(list.rows[*row], role); !refusal.empty()) {
        list.error = fmt::format("grid '{}' can't be the {}: {}", grid, role_name(role), refusal);
        return;
    }
    waiting_.push_back({medium, list.rows[*row].name, role});
}

void GridRouter::follow(const Scene& moving, const Scene& shown, int frame)
{
    if (running_ || waiting_.empty())
        return;
    running_ = std::move(waiting_.front());
    waiting_.pop_front();
    const Asked asked = *running_;
    const std::vector<GridRow>& rows = lists_[asked.medium].rows;
    const auto& medium = std::get<GridMedium>(shown.media[asked.medium]);
    remember_parts(memory_[asked.medium], medium);
    RoutedMedium routed = with_role(medium, rows, find_row(rows, asked.grid).value(), asked.role,
                                    memory_[asked.medium]);
    routing_.run([routed = std::move(routed), frame, number = asked.medium,
                  unread = std::get<GridMedium>(moving.media[asked.medium]),
                  rate = moving.frames_per_second, shared = shared_](const Background::Stop&) {
        std::optional<Routed> result;
        std::string error;
        try {
            result = read(routed, unread, rate, frame);
            result->medium = number;
        } catch (const std::exception& failed) {
            error = why(failed);
        }
        const std::lock_guard lock(shared->lock);
        shared->routed = std::move(result);
        shared->error = error;
        shared->done = true;
    });
}

std::optional<GridRouter::Routed> GridRouter::take_routed()
{
    const std::lock_guard lock(shared_->lock);
    if (!running_ || !shared_->done)
        return std::nullopt;
    shared_->done = false;
    if (!shared_->error.empty()) {
        lists_[running_->medium].error = shared_->error;
        lists_[running_->medium].wrong = running_->grid;
    }
    running_.reset();
    return std::exchange(shared_->routed, std::nullopt);
}

bool GridRouter::busy() const
{
    return routing() || listing_.busy();
}

std::string GridRouter::progress() const
{
    if (!running_)
        return "";
    return running_->role == GridRole::off
               ? fmt::format("switching '{}' off", running_->grid)
               : fmt::format("reading '{}' as {}", running_->grid, role_name(running_->role));
}

}  // namespace fumarole::window
