# SPDX-License-Identifier: MIT
"""Runs inside GIMP 3 (python-fu-eval): does the jobs of jobs.json, notes what came of each.

The directory is in the environment variable NTP_JOBS.  A job has a "file" to open and "steps", each
[name, argument...] of a function below.  results.json gets, for each job, null or an error.
"""

import json
import os
import traceback

from gi.repository import Gegl, Gimp, Gio

HERE = os.environ["NTP_JOBS"]
QUIET = Gimp.RunMode.NONINTERACTIVE


def path(name):
    return Gio.File.new_for_path(os.path.join(HERE, name))


class Session:
    """One image, and what is done to it."""

    def __init__(self, file):
        self.image = Gimp.file_load(QUIET, path(file))
        self.notes = {}

    @property
    def layer(self):
        return self.image.get_layers()[0]

    def _filter(self, operation, settings, layer=None):
        made = Gimp.DrawableFilter.new(layer or self.layer, operation, "")
        config = made.get_config()
        for name, value in settings.items():
            config.set_property(name, value)
        made.update()
        return made

    def merge(self, operation, settings):
        self.layer.merge_filter(self._filter(operation, settings))

    def append(self, operation, settings, target="layer"):
        layer = getattr(self, target)
        layer.append_filter(self._filter(operation, settings, layer))

    def each(self, things):
        """Does each [file, how, operation, settings] to a copy; dumps what is shown then.

        This is a fraction of what opening and saving takes.  Settings of "aux" are true: the pad
        gets the second layer.
        """
        original, self.notes["each"] = self.image, {}
        for file, how, operation, settings in things:
            self.image = original.duplicate()
            try:
                aux = settings.pop("aux", False)
                made = self._filter(operation, settings)
                if aux:
                    made.set_aux_input("aux", self.image.get_layers()[1])
                    made.update()
                getattr(self.layer, f"{how}_filter")(made)
                if how == "append":  # what an export does
                    self.layer.merge_filters()
                self.dump(file)
                self.notes["each"][file] = self.notes.pop("shape")
            finally:
                self.image.delete()
                self.image = original

    def note_place(self):
        """Where the layer begins, and the image's size."""
        x, y = self.layer.get_offsets()[-2:]
        self.notes["place"] = [x, y, self.image.get_width(), self.image.get_height()]

    def discard_profile(self):
        """What Image > Color Management > Discard Color Profile does: the numbers stay."""
        gray = self.image.get_base_type() == Gimp.ImageBaseType.GRAY
        profile = (
            Gimp.ColorProfile.new_d65_gray_srgb_trc if gray else Gimp.ColorProfile.new_rgb_srgb
        )
        self.image.set_color_profile(profile())

    def precision(self, name):
        self.image.convert_precision(getattr(Gimp.Precision, name))

    def mode(self, name):
        if name == "rgb":
            self.image.convert_rgb()
        elif name == "gray":
            self.image.convert_grayscale()
        else:
            none = Gimp.ConvertDitherType.NONE
            self.image.convert_indexed(
                none, Gimp.ConvertPaletteType.GENERATE, 256, False, False, ""
            )

    def select(self, x, y, width, height):
        self.image.select_rectangle(Gimp.ChannelOps.REPLACE, x, y, width, height)

    def select_all(self):
        Gimp.Selection.none(self.image)

    def add_alpha(self):
        self.layer.add_alpha()

    def offsets(self, x, y):
        self.layer.set_offsets(x, y)

    def enlarge(self, width, height, x, y):
        self.image.resize(width, height, x, y)

    def group(self):
        """The layer becomes the only one of a group, which is then the first layer."""
        group = Gimp.GroupLayer.new(self.image, "group")
        self.image.insert_layer(group, None, 0)
        self.image.reorder_item(self.image.get_layers()[1], group, 0)

    def other(self, file):
        """A second layer, below the first; "other" as an argument."""
        self.second = Gimp.file_load_layer(QUIET, self.image, path(file))
        self.image.insert_layer(self.second, None, 1)

    def hide_other(self, file):
        self.other(file)
        self.second.set_visible(False)

    def mask(self, kind="WHITE"):
        self.layer.add_mask(self.layer.create_mask(getattr(Gimp.AddMaskType, kind)))

    def text(self):
        """The layer becomes text, which a parasite tells in a file; there are no fonts here."""
        mark = Gimp.Parasite.new("gimp-text-layer", 1, b'(text "A")\0')
        self.layer.attach_parasite(mark)
        self.save("text.xcf")
        self.image.delete()
        self.image = Gimp.file_load(QUIET, path("text.xcf"))

    def link(self, file):
        """A layer that shows a file becomes the first one (GIMP 3.2)."""
        self.image.insert_layer(Gimp.LinkLayer.new(self.image, path(file)), None, 0)

    def vector(self):
        """A layer that shows a path becomes the first one (GIMP 3.2)."""
        drawn = Gimp.Path.new(self.image, "path")
        self.image.insert_path(drawn, None, 0)
        drawn.bezier_stroke_new_ellipse(70, 60, 40, 30, 0)
        shape = Gimp.VectorLayer.new(self.image, drawn)
        self.image.insert_layer(shape, None, 0)
        shape.refresh()

    def hide_filters(self):
        for effect in self.layer.get_filters():
            effect.set_visible(False)

    def note_filters(self):
        self.notes["filters"] = len(self.layer.get_filters())
        self.notes["images"] = len(Gimp.get_images())

    def newest(self):
        """The newest image takes the place of this one."""
        self.image.delete()
        self.image = max(Gimp.get_images(), key=Gimp.Image.get_id)

    def lock(self):
        self.layer.set_lock_content(True)

    def call(self, procedure, settings, target="layer"):
        """A procedure on the layer, its mask or none; notes what it answers, or why it refuses."""
        made = Gimp.get_pdb().lookup_procedure(procedure)
        config = made.create_config()
        config.set_property("run-mode", QUIET)
        config.set_property("image", self.image)
        targets = {"layer": [self.layer], "mask": [self.layer.get_mask()], "none": []}
        config.set_core_object_array("drawables", targets[target])
        for name, value in settings.items():
            config.set_property(name, self.second if value == "other" else value)
        answer = made.run(config)
        if answer.index(0) == Gimp.PDBStatusType.SUCCESS:
            self.notes["values"] = [answer.index(i) for i in range(1, answer.length())]
        else:
            self.notes["refused"] = Gimp.get_pdb().get_last_error()
            self.notes["status"] = answer.index(0).value_nick

    def note_profile(self):
        profile = self.image.get_color_profile()
        self.notes["profile"] = profile and profile.get_label()

    def save(self, file):
        Gimp.file_save(QUIET, self.image, path(file), None)

    def reopen(self, file, noted="scale"):
        self.save(file)
        self.image.delete()
        self.image = Gimp.file_load(QUIET, path(file))
        self.notes["filters"] = [f.get_operation_name() for f in self.layer.get_filters()]
        self.notes[noted] = self.layer.get_filters()[0].get_config().get_property(noted)

    def dump(self, file):
        """The bytes of the layer as they are stored, and in the notes what they are."""
        buffer = self.layer.get_buffer()
        box = Gegl.Rectangle.new(0, 0, self.layer.get_width(), self.layer.get_height())
        with open(os.path.join(HERE, file), "wb") as out:
            out.write(bytes(buffer.get(box, 1.0, None, Gegl.AbyssPolicy.NONE)))
        self.notes["shape"] = [
            self.layer.get_height(),
            self.layer.get_width(),
            self.layer.get_bpp(),
        ]


def main():
    with open(os.path.join(HERE, "jobs.json"), encoding="utf-8") as file:
        jobs = json.load(file)
    results = {}
    for name, job in jobs.items():
        try:
            session = Session(job["file"])
            for step, *arguments in job["steps"]:
                getattr(session, step)(*arguments)
            results[name] = {"error": None, **session.notes}
            session.image.delete()
        except Exception:  # noqa: BLE001 - whatever it is, the report says it
            results[name] = {"error": traceback.format_exc()}
    with open(os.path.join(HERE, "results.json"), "w", encoding="utf-8") as file:
        json.dump(results, file)


main()
