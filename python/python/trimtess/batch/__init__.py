"""Converts archives of CAD files to meshes on Ray, from one machine to a cluster.

A *source* is one input file. A *bundle* is what one Ray task converts: one large source or many small ones. Each
source is converted in a process of its own, forked by a *server* that has `trimtess` loaded. A *result* is the folder
of outputs of one input, named by the hash of the input, the options and the version. A *row* is what the *catalogue*
says about one source.

    sources  arguments -> sources: folders, globs, manifests, URLs
    plan     sources -> bundles, with the memory and cores to ask for
    task     one bundle on a worker -> outcomes; starts the server
    server   one source at a time -> a forked process with limits
    convert  one source -> a result in the store
    drive    bundles, retries, rows; talks to Ray through cluster
    report   a catalogue -> text and plots

The command is `trimtess-batch`. docs/batch.md is the manual.
"""
