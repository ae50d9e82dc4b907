#include "resolve/layers.h"

#include <optional>

#include "pass/froxels.h"
#include "pass/ray_march.h"
#include "resolve/froxel_lookup.h"
#include "resolve/march_history.h"
#include "resolve/upsample.h"

namespace fumarole::resolve {

namespace {

class MarchLayers : public Layers {
public:
    explicit MarchLayers(const Toolbox& tools) : tools_{tools}, march_{tools} {}

    void draw(const PreparedFrame& frame) override
    {
        if (!frame.settings.keeps_history())
            history_.reset();
        march_.draw(frame);
        draw_fine(frame);
        averaged_ = frame.keeps_history;
        if (!averaged_)
            return;
        if (!history_)
            history_.emplace(tools_);
        history_->add(frame, march_.layer());
    }

    void resolve(const PreparedFrame& frame, Layer layer, const Canvas& canvas,
                 const gl::Defines& variant) override
    {
        pass::MarchedLayer marched = march_.layer();
        if (averaged_)
            history_->replace(marched);
        upsample(frame, marched, layer, canvas, variant);
        if (!fine_ || frames_without_fine_ > 0)
            return;
        tools_.bind_block(fine_->frame);
        upsample(fine_->frame, fine_->march.layer(), layer, canvas, variant);
        tools_.bind_block(frame);
    }

    [[nodiscard]] gl::Defines bind_volume_at(const PreparedFrame& frame) override
    {
        return march_.bind_split_layers(frame.settings);
    }
    [[nodiscard]] const pass::StepTiles* media_tiles() const override
    {
        return march_.layer().tiles;
    }
    [[nodiscard]] HostVolume host_volume(const PreparedFrame& frame) override
    {
        const pass::MarchedLayer layer = march_.layer();
        const pass::SplitLayers splits = march_.splits();
        HostVolume volume;
        volume.params.frame = frame.params;
        volume.params.splits = *splits.depths;
        volume.params.kind = VOLUME_AT_SPLITS;
        volume.params.layer_scale = layer.scale;
        volume.params.transmittance = layer.grey ? VOLUME_AT_GREY : VOLUME_AT_APART;
        volume.textures = {nullptr, nullptr, layer.depth, splits.scattering, splits.transmittance};
        return volume;
    }
    [[nodiscard]] std::uint64_t volume_at_bytes() const override { return march_.split_bytes(); }

    [[nodiscard]] const char* resolve_name() const override { return "upsample"; }
    [[nodiscard]] pass::VolumePass& pass() override { return march_; }
    [[nodiscard]] OwnLayers own() const override
    {
        pass::MarchedLayer marched = march_.layer();
        if (averaged_)
            history_->replace(marched);
        OwnLayers own;
        own.scattering = marched.scattering->view();
        own.grey = marched.grey;
        if (!own.grey)
            own.transmittance = marched.transmittance->view();
        own.depth = marched.depth->view();
        own.guard = marched.guard;
        own.scale = marched.scale;
        return own;
    }
    void reset_history() override
    {
        if (history_)
            history_->drop_history();
    }
    [[nodiscard]] const char* history_use() const override
    {
        return history_ ? history_->use() : "";
    }

private:
    /// Where a ray for several pixels does not do, there is one for each, in a layer of its own.
    struct Fine {
        explicit Fine(const Toolbox& tools) : march{tools} {}
        pass::RayMarch march;
        PreparedFrame frame;
    };

    void draw_fine(const PreparedFrame& frame)
    {
        if (frame.fine_tiles.empty()) {
            if (++frames_without_fine_ > kKeepsFine)
                fine_.reset();
            return;
        }
        frames_without_fine_ = 0;
        if (!fine_)
            fine_.emplace(tools_);
        fine_->frame = fine_frame(frame);
        tools_.bind_block(fine_->frame);
        fine_->march.draw(fine_->frame);
        tools_.bind_block(frame);
    }

    const Toolbox& tools_;
    pass::RayMarch march_;
    /// Frames without fine tiles that their layer is kept for: a look inside between two frames
    /// must not make it anew, nor a sun that comes and goes at the picture's edge.
    static constexpr int kKeepsFine = 64;
    std::optional<Fine> fine_;  ///< where frames have fine tiles, or had some of late
    int frames_without_fine_ = 0;
    std::optional<MarchHistory> history_;  ///< while the settings ask for it
    bool averaged_ = false;                ///< the last frame has a history
};

class FroxelLayers : public Layers {
public:
    explicit FroxelLayers(const Toolbox& tools) : tools_{tools}, froxels_{tools} {}

    void draw(const PreparedFrame& frame) override { froxels_.draw(frame); }
    void resolve(const PreparedFrame& frame, Layer layer, const Canvas& canvas,
                 const gl::Defines& variant) override
    {
        froxels_.write_block(frame);
        look_up(tools_, frame, froxels_.integrated(), layer, canvas, variant);
    }
    [[nodiscard]] gl::Defines bind_volume_at(const PreparedFrame& frame) override
    {
        froxels_.write_block(frame);
        return bind_lookup(frame, froxels_.integrated());
    }
    [[nodiscard]] HostVolume host_volume(const PreparedFrame& frame) override
    {
        const pass::IntegratedFroxels froxels = froxels_.integrated();
        HostVolume volume;
        volume.params.frame = frame.params;
        volume.params.froxels = froxels_.block(frame);
        volume.params.kind = VOLUME_AT_FROXELS;
        volume.params.layer_scale = 1;
        volume.params.transmittance =
            froxels.storage == pass::FroxelExtinction::grey    ? VOLUME_AT_GREY
            : froxels.storage == pass::FroxelExtinction::apart ? VOLUME_AT_APART
                                                               : VOLUME_AT_RED_IN_ALPHA;
        volume.params.tricubic = frame.settings.lookup == Settings::Lookup::tricubic ? 1 : 0;
        volume.textures = {froxels.scattering, froxels.transmittance, nullptr, nullptr, nullptr};
        return volume;
    }
    [[nodiscard]] const char* resolve_name() const override { return "froxel lookup of"; }
    [[nodiscard]] pass::VolumePass& pass() override { return froxels_; }
    [[nodiscard]] OwnLayers own() const override
    {
        const pass::IntegratedFroxels froxels = froxels_.integrated();
        OwnLayers own;
        own.scattering = froxels.scattering->view();
        own.transmittance = froxels.transmittance->view();
        own.grey = !own.transmittance;
        return own;
    }
    void reset_history() override { froxels_.drop_history(); }
    [[nodiscard]] const char* history_use() const override { return froxels_.history_use(); }

private:
    const Toolbox& tools_;
    pass::Froxels froxels_;
};

}  // namespace

std::unique_ptr<Layers> make_layers(Settings::Mode mode, const Toolbox& tools)
{
    if (mode == Settings::Mode::froxel)
        return std::make_unique<FroxelLayers>(tools);
    return std::make_unique<MarchLayers>(tools);
}

}  // namespace fumarole::resolve
