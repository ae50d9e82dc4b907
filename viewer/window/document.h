#pragma once

#include <map>
#include <string>
#include <vector>

#include "window/change.h"
#include "window/grid_router.h"
#include "window/scene_loader.h"
#include "window/sequence.h"
#include <fumarole/scene.h>

namespace fumarole::window {

/// The open scene: as it was read, as it has been edited since, and its frames in time.
class Document {
public:
    /// An empty document, or one whose file is being read. @param input its file "" for empty
    explicit Document(const command::SceneInput& input);

    /// Starts to read another file. The scene that is there stays until that one has come.
    void open(const std::string& file);

    /// Takes what was read since the last call.
    /// @throws Error if the file can't be read; what was there stays
    Change take_loaded();

    /// Moves the playhead by the time that went by, and takes its frame once that is read. Edits of
    /// media and lights stay, and so does a camera that was moved.
    /// @throws Error if the frame can't be read; the playhead stops at the one shown
    Change play(double seconds);

    /// The scene as it is drawn, to be edited.
    [[nodiscard]] Scene& scene() { return scene_; }
    [[nodiscard]] const Scene& scene() const { return scene_; }
    /// The scene as it was read, of the frame shown: what a reset goes back to.
    [[nodiscard]] const Scene& as_read() const { return as_read_; }
    /// The scene as it was read, with the #s of its sequences: what a command line would render.
    [[nodiscard]] const Scene& as_opened() const { return moving_; }
    /// The scene as it is drawn, with the #s of its sequences: what is saved of it.
    [[nodiscard]] Scene to_save() const;
    /// Whether all files of the scene are read; until then it can't be edited.
    [[nodiscard]] bool whole() const { return whole_; }
    /// Whether it is empty, with nothing on its way.
    [[nodiscard]] bool empty() const { return input_.file.empty() && !loading(); }
    /// Whether anything can be drawn.
    [[nodiscard]] bool drawable() const
    {
        return whole_ || !scene_.media.empty() || !scene_.surfaces.empty();
    }
    /// Whether neither camera nor media nor lights differ from the file's.
    [[nodiscard]] bool untouched() const;
    /// Whether the whole scene is there and nothing of it plays or is being read.
    [[nodiscard]] bool at_rest() const;

    /// Its transparents, with those that are switched off, in one order.
    [[nodiscard]] std::size_t transparent_count() const
    {
        return scene_.transparents.size() + off_.size();
    }
    [[nodiscard]] Transparent& transparent(std::size_t i);
    [[nodiscard]] bool is_on(std::size_t i) const { return off_.count(i) == 0; }
    /// Takes one out of the scene, or puts it back where it was.
    void switch_transparent(std::size_t i, bool on);
    void remove_transparent(std::size_t i);

    /// What the files of its media hold, and what each grid is taken for.
    [[nodiscard]] const GridRouter& grids() const { return grids_; }
    /// Takes a grid for one thing alone, once it is read. Why that can't be is said in its list.
    /// @throws Error if the scene has no such medium
    void give_role(std::size_t medium, const std::string& grid, GridRole role);

    /// The words that the scene was opened by.
    [[nodiscard]] const command::SceneInput& input() const { return input_; }
    [[nodiscard]] const std::vector<std::string>& notes() const { return notes_; }
    /// Whether a scene is being read, or a grid of the one that is there.
    [[nodiscard]] bool loading() const { return loader_.loading() || grids_.routing(); }
    /// What is being read, or "".
    [[nodiscard]] std::string progress() const
    {
        return loader_.loading() ? loader_.progress() : grids_.progress();
    }

    [[nodiscard]] Sequence& sequence() { return sequence_; }
    [[nodiscard]] const Sequence& sequence() const { return sequence_; }

private:
    /// Of one that is on, in the scene.
    [[nodiscard]] std::size_t place_of(std::size_t i) const;
    void take_images(const Scene& frame);
    Change take_scene();
    Change take_routed();

    SceneLoader loader_;
    command::SceneInput input_;
    Scene scene_, as_read_;
    std::map<std::size_t, Transparent>
        off_;  ///< transparents that are off, by their places among all
    std::vector<std::string> notes_;
    bool whole_ = false;
    Sequence sequence_;
    Scene moving_;  ///< with the #s of its sequences
    GridRouter grids_;
    std::vector<std::map<GridRole, std::string>> parts_read_;  ///< of the media, by the file
    std::vector<RoleMemory> read_memory_;                      ///< of the media of as_read_
    Background retired_;                                       ///< ends what may still be reading
};

}  // namespace fumarole::window
