"""The laboratory of motes: what measures, simulates, teaches and torments the engine, its first client.

`bench` measures, `cluster` simulates clusters, `arena` compares balancers on the loads of `workloads`, and
`course` teaches. The commands are in `cli`. Scripts write `motes.cluster`, `motes.course`, `motes.workloads`.
"""
